from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tracking_world import drive, follow, short_drive

from circumspect.mapping import RegisteredPoses, TrackingSettings
from circumspect.mapping.keyframe_pairs import OLD, closes_a_loop, is_consecutive
from circumspect.mapping.keyframes import Keyframes, KeyframeSettings
from circumspect.mapping.pair_queue import PairQueue

LOOP = (0, OLD + 1)


def queue_of(pairs: list[tuple[int, int]]) -> PairQueue:
    queue = PairQueue()
    queue.put(pairs)
    return queue


def taken(queue: PairQueue, hurry: bool = False) -> list[tuple[int, int]]:
    return [queue.take(hurry) for _ in range(len(queue))]


def test_what_two_keyframes_bring_is_no_crowd_and_taken_as_it_came() -> None:
    pairs = [(n, m) for m in (20, 21) for n in (m - 1, 18, 17, 16, 14, 2)]
    queue = queue_of(pairs)
    assert not queue.is_crowded
    queue.put([LOOP])
    assert queue.is_crowded
    assert taken(queue) == [*pairs, LOOP]


def test_in_a_hurry_the_chain_comes_first_and_loops_next() -> None:
    pairs = [(n, m) for m in range(20, 26) for n in (m - 2, m - 3, m - 15, m - 1)]
    order = taken(queue_of(pairs), hurry=True)
    assert sorted(order) == sorted(pairs)
    assert all(is_consecutive(*pair) for pair in order[:6])
    assert all(closes_a_loop(*pair) for pair in order[6:12])
    # Of the same kind in turn.
    others = [pair for pair in pairs if pair[1] - pair[0] in (2, 3)]
    assert order[12:] == others


@pytest.mark.parametrize(("pair", "held"), [((4, 5), True), (LOOP, True), ((3, 5), False)])
def test_a_correction_waits_for_the_chain_and_for_loops(pair: tuple[int, int], held: bool) -> None:
    assert queue_of([(0, 3), pair]).holds_up is held


def test_nothing_waits_of_a_keyframe_that_was_taken_out() -> None:
    queue = queue_of([(1, 2), (2, 3), (1, 3), (2, 5)])
    assert queue.take_out(2) == [(1, 2), (2, 3), (2, 5)]
    assert taken(queue) == [(1, 3)]
    for hurry in (False, True):
        with pytest.raises(IndexError):
            queue.take(hurry)


@pytest.mark.parametrize("step_deg", [5.0, 12.5])
def test_loops_are_closed_while_a_robot_drives_fast(step_deg: float) -> None:
    """At 13 cm a frame every second one is a keyframe, at 33 cm every one."""
    keyframes = KeyframeSettings(rebuild_shift=0.0, rebuild_turn=0.0)
    poses = RegisteredPoses(settings=TrackingSettings(keyframes=keyframes))
    follow(drive(np.radians(np.arange(45, 45 + 360 + 35, step_deg))), poses)
    assert poses.keyframes.loops > 0
    assert poses.corrections > 0


def test_a_frame_has_one_thing_to_do_beside_being_placed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unless too many pairs wait; and what the end of frames corrected is not corrected again."""
    done: list[str] = []

    def noted(name: str) -> None:
        plain = getattr(Keyframes, name)

        def noting(self: Keyframes, *given: Any) -> Any:
            hurried = name == "fit_next" and any(given)
            done.append("in a hurry" if hurried else name)
            return plain(self, *given)

        monkeypatch.setattr(Keyframes, name, noting)

    for name in ("add", "fit_next", "correct"):
        noted(name)
    poses = RegisteredPoses()
    angles = np.radians(np.arange(45, 45 + 360 + 36, 3.0))
    # A robot that stands leaves time for all that waits.
    *frames, last = drive(np.concatenate([angles, np.full(15, angles[-1])]))
    jobs = set()
    for frame in frames:
        done.clear()
        poses.estimate(frame)
        poses.catch_up()
        jobs.add(tuple(done))
    jobs = {job for job in jobs if "in a hurry" not in job}
    assert jobs == {(), ("add",), ("fit_next",), ("correct",)}
    poses.settle()
    done.clear()
    poses.estimate(last)
    assert "correct" not in done


def test_who_is_interrupted_while_settling_may_settle_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    poses = RegisteredPoses()
    follow(short_drive(), poses)

    def interrupted() -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(poses.keyframes, "fit_what_wheels_held", interrupted)
        with pytest.raises(KeyboardInterrupt):
            poses.settle()
    before = poses.corrections
    poses.settle()
    assert poses.corrections == before + 1
