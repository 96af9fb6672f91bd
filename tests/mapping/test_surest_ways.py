"""How well keyframes are known, and which of them hold a camera."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from test_bounded_memory import AHEAD, corner
from tracking_world import drive, follow

from circumspect.geometry import se3
from circumspect.mapping import RegisteredPoses, TrackingSettings, keyframes
from circumspect.mapping.keyframe import Keyframe
from circumspect.mapping.keyframes import Keyframes, KeyframeSettings
from circumspect.mapping.surest_ways import agreeing, by_surest_ways, moved_covariance
from circumspect.mapping.wheels import Passage
from circumspect.pose_graph import BetweenFactor

I6 = np.eye(6)
STEP = 1e-4 * I6
SEEN = corner(np.random.default_rng(0))


def chain(count: int, rng: np.random.Generator) -> list[Keyframe]:
    """Keyframes of a drive, each known from the one before to `STEP`."""
    T, covariance, keys = RigidTransform.identity(), STEP, []
    for number in range(count):
        if number:
            move = se3.exp(rng.uniform(-0.3, 0.3, 6))
            T, covariance = T * move, se3.moved_covariance(move.inv(), covariance) + STEP
        parent = number - 1 if number else None
        keys.append(Keyframe.of(number, T, covariance, SEEN, AHEAD, Passage(), parent, STEP))
    return keys


def edge(one: Keyframe, other: Keyframe, variance: float, off: float = 0.0) -> BetweenFactor:
    measured = one.T_map_camera.inv() * other.T_map_camera * se3.exp([0, 0, 0, off, 0, 0])
    return BetweenFactor(one.number, other.number, measured, I6 / variance, robust=True)


def place(covariance: np.ndarray) -> float:
    return float(np.trace(covariance[3:, 3:]))


@pytest.mark.parametrize("seed", range(5))
def test_without_loops_covariances_are_those_of_the_drive(seed: int) -> None:
    keys = chain(12, np.random.default_rng(seed))
    surest = by_surest_ways(keys, [])
    for key in keys:
        np.testing.assert_allclose(
            surest[key.number].covariance, key.covariance, rtol=1e-9, atol=1e-12
        )


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("turned_round", [False, True])
def test_a_loop_makes_its_end_surer_and_what_lies_before_it(seed: int, turned_round: bool) -> None:
    keys = chain(30, np.random.default_rng(seed))
    loop = edge(keys[29], keys[0], 1e-4) if turned_round else edge(keys[0], keys[29], 1e-4)
    surest = by_surest_ways(keys, [loop])
    for key in keys:
        assert place(surest[key.number].covariance) <= place(key.covariance) * (1 + 1e-9)
    if not turned_round:
        np.testing.assert_allclose(
            surest[29].covariance,
            moved_covariance(keys[0], keys[29]) + 1e-4 * I6,
            rtol=1e-9,
            atol=1e-12,
        )
    # Back from the end: one step less sure than it, the drive's beginning as it was.
    back = se3.moved_covariance(
        keys[28].T_map_camera.inv() * keys[29].T_map_camera, surest[29].covariance + STEP
    )
    np.testing.assert_allclose(surest[28].covariance, back, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(surest[1].covariance, keys[1].covariance, rtol=1e-9, atol=1e-12)


def test_an_edge_that_the_poses_contradict_is_told_apart() -> None:
    one, other = chain(2, np.random.default_rng(0))
    near, far = (edge(one, other, 1e-4, off=off) for off in (0.02, 0.1))
    keys = {key.number: key for key in (one, other)}
    assert agreeing([far, near, far], keys) == [near]
    assert agreeing([], keys) == []


def on_a_line(places: list[float]) -> Keyframes:
    s = TrackingSettings()
    keys = Keyframes(0.03, KeyframeSettings(), s.registration, s.gate, I6[:3, :3])
    for x in places:
        keys.add(se3.exp([0, 0, 0, x, 0, 0]), STEP, SEEN, AHEAD, Passage())
    return keys


def test_who_comes_back_is_held_by_the_way_until_the_graph_agrees(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there_and_back = [0.3 * n for n in [*range(10), *range(9, 0, -1)]]
    keys = on_a_line(there_and_back)
    T = RigidTransform.from_translation([0.05, 0.0, 0.0])
    assert keys.holding(T) == (18, pytest.approx(0.25 / 0.2))
    assert place(keys.covariance(T, STEP)) > 8 * place(STEP)
    keys.queue.put([(0, 18)])
    monkeypatch.setattr(keyframes, "pair_edge", lambda one, other, *_: edge(one, other, 1e-4))
    while len(keys.queue):
        keys.fit_next()
    keys.correct(anyway=True)
    assert keys.holding(T)[0] == 0
    assert place(keys.covariance(T, STEP)) < 4 * place(STEP)


def test_who_turns_round_soon_is_held_by_what_is_near() -> None:
    keys = on_a_line([0.3 * n for n in range(6)])
    assert keys.holding(RigidTransform.from_translation([0.29, 0.0, 0.0]))[0] == 1


def test_who_was_found_again_is_held_by_what_is_near() -> None:
    keys = on_a_line([0.3 * n for n in range(20)])
    T = RigidTransform.identity()
    assert keys.holding(T)[0] == 7
    keys.found_again()
    assert keys.holding(T)[0] == 0


def test_what_gave_way_leaves_the_covariance_of_the_way_as_it_was() -> None:
    s = TrackingSettings()
    keys = Keyframes(0.03, KeyframeSettings(most=5), s.registration, s.gate, I6[:3, :3])
    for number in range(20):
        keys.add(se3.exp([0, 0.02 * number, 0, 0.1 * number, 0, 0]), STEP, SEEN, AHEAD, Passage())
    before = keys[19].covariance
    keys.correct(anyway=True)
    assert len(keys) == 5
    np.testing.assert_allclose(keys[19].covariance, before, rtol=1e-2, atol=1e-5)


def test_a_round_is_told_less_surely_until_it_is_closed() -> None:
    angles = np.radians(np.arange(45, 430, 5.0))
    poses = RegisteredPoses()
    told = [place(pose.covariance) for pose in follow(drive(angles), poses)]
    widest = int(np.argmax(told))
    assert poses.keyframes.loops > 0
    assert told[widest] > 1.5 * told[0]
    assert min(told[widest:]) < 0.8 * told[widest]
