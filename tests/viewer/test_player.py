"""The time bar moves during playback and by the user; the user takes precedence."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from circumspect.classification import Classifier
from circumspect.viewer import Dashboard, PlayedRun, Player, SavedRun


class _Watched(Dashboard):
    """A dashboard with a viewer that records the shown frames."""

    def __init__(self) -> None:
        super().__init__(Classifier.load(), port=0)
        self.made: list[int] = []

    watched = property(lambda self: True)

    def put(self, make: Callable) -> None:
        self.made.append(make().count)


@pytest.fixture
def dashboard():
    with _Watched() as opened:
        yield opened


@pytest.fixture
def player(dashboard, finished_run):
    player = Player(PlayedRun(SavedRun.load(finished_run)), dashboard)
    player.speed.value = "20 frames/s"
    yield player
    player.close()


def until(condition) -> None:
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.01)


def test_playback_shows_every_frame_and_stops_at_the_end(player, dashboard):
    until(lambda: player.button.label == "Play")
    assert dashboard.made == [1, 2, 3, 4, 5, 6]
    assert player.bar.value == 6


def test_a_moved_time_bar_stays(player, dashboard):
    until(lambda: player.button.label == "Play")
    for place in (2, 5):
        player.bar.value = place
        assert dashboard.made[-1] == place
        time.sleep(0.15)
        assert (player.bar.value, dashboard.made[-1]) == (place, place)


def test_moving_the_time_bar_stops_playback(player, dashboard):
    until(lambda: len(dashboard.made) >= 2)
    player.bar.value = 1
    assert player.button.label == "Play"
    time.sleep(0.2)
    assert player.bar.value == 1
    assert dashboard.made[-1] == 1


@pytest.mark.parametrize(("sent", "frame"), [(-3, 1), (99, 1), ("x", 1)])
def test_an_invalid_frame_shows_the_first(player, dashboard, sent, frame):
    until(lambda: player.button.label == "Play")
    player.bar._impl.value = sent
    player._heed_bar()
    assert dashboard.made[-1] == frame
