"""A thread shows the newest state; `put` never waits."""

from __future__ import annotations

import threading
import time

import pytest

from circumspect.viewer.publisher import NewestSlot, Publisher

LONG = 20.0


def until(condition) -> None:
    end = time.monotonic() + LONG
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.005)


def test_only_the_newest_value_is_taken_and_only_once():
    slot = NewestSlot()
    for value in range(5):
        slot.put(value)
    assert slot.take(0) == 4
    assert slot.take(0) is None


def test_again_returns_the_latest_value():
    slot = NewestSlot()
    slot.again()
    assert slot.take(0) is None
    slot.put("a")
    slot.take(0)
    slot.again()
    assert slot.take(0) == "a"


def test_closing_a_slot_releases_waiting_threads():
    slot, taken = NewestSlot(), []
    waiting = threading.Thread(target=lambda: taken.append(slot.take()), daemon=True)
    waiting.start()
    slot.close()
    waiting.join(LONG)
    assert taken == [None]


def test_a_hanging_page_does_not_delay_put():
    hanging, let_go = threading.Event(), threading.Event()

    def hang(state):
        hanging.set()
        let_go.wait(LONG)

    publisher = Publisher(hang)
    publisher.slot.put(0)
    assert hanging.wait(LONG)
    began = time.monotonic()
    for state in range(1, 2001):
        publisher.slot.put(state)
    assert time.monotonic() - began < 1.0
    assert publisher.shown == 0
    let_go.set()
    publisher.close()


def test_a_slow_page_skips_to_the_newest():
    shown = []
    publisher = Publisher(lambda state: (shown.append(state), time.sleep(0.05)))
    for state in range(100):
        publisher.slot.put(state)
        time.sleep(0.001)
    until(lambda: shown and shown[-1] == 99)
    assert len(shown) < 50
    assert shown == sorted(shown)
    publisher.close()


def test_a_failing_page_is_reported_once_and_retried_with_the_next_state(caplog):
    shown = []

    def fail_first(state):
        if state < 2:
            raise RuntimeError("the page is gone")
        shown.append(state)

    publisher = Publisher(fail_first)
    publisher.slot.put(0)
    until(lambda: publisher.failure is not None)
    publisher.slot.put(1)
    publisher.slot.put(2)
    until(lambda: shown == [2])
    assert "gone" in str(publisher.failure)
    assert [record.getMessage() for record in caplog.records] == [
        "the page can not be shown: the page is gone"
    ]
    publisher.close()


def test_nothing_is_shown_without_viewers_and_the_newest_state_with_one():
    shown, watched = [], threading.Event()
    publisher = Publisher(shown.append, watched.is_set)
    publisher.slot.put(1)
    publisher.slot.put(2)
    time.sleep(0.1)
    assert shown == []
    watched.set()
    publisher.slot.again()
    until(lambda: shown == [2])
    publisher.close()


@pytest.mark.parametrize("most_often", [10.0, 40.0])
def test_the_rate_of_updates_is_limited(most_often):
    publisher = Publisher(lambda state: None, most_often=most_often)
    until_time = time.monotonic() + 0.5
    while time.monotonic() < until_time:
        publisher.slot.put(0)
        time.sleep(0.002)
    assert 1 <= publisher.shown <= 0.5 * most_often + 2
    publisher.close()
