"""The map stays small, and knows which keyframe a camera is referenced to."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import drive, follow

from circumspect.geometry import PinholeCamera, se3_matrices
from circumspect.motion import PoseWithCovariance
from circumspect.pose_graph import BetweenFactor, KeyframeMap, KeyframeSettings, keyframe_map
from circumspect.pose_graph.keyframe_graph import MAX_FACTORS_PER_KEYFRAME
from circumspect.pose_graph.keyframe_map import MERGED_TOGETHER
from circumspect.pose_graph.loop_closure import COVISIBILITY_GAPS, LOOP_GAP
from circumspect.registration import Scan, SurfaceMap
from circumspect.sensing import RgbdFrame
from circumspect.tracking import Tracker

AHEAD = RgbdFrame(np.full((24, 32), 2.0), PinholeCamera(32, 24, 24.0, 24.0, 15.5, 11.5), 0.0)
STEP = 1e-4 * np.eye(6)


def corner(rng: np.random.Generator) -> Scan:
    """Points on three walls; enough to be registered."""
    flat = rng.uniform(0.0, 1.0, (3, 150, 2))
    walls = [np.insert(points, axis, 0.0, axis=1) for axis, points in enumerate(flat)]
    ahead = np.array([0.0, 0.0, 1.0])
    return Scan.with_white_noise(np.concatenate(walls) + ahead, np.full(450, 2e-3))


def at(*tangent: float) -> PoseWithCovariance:
    return PoseWithCovariance(se3_matrices.exp(np.array(tangent)), STEP)


def loops_of_keyframes(max_keyframes: int, count: int, registering: bool = True) -> KeyframeMap:
    """Keyframes round and round a small circle, each referenced to the one before."""
    rng, settings = np.random.default_rng(0), KeyframeSettings(max_keyframes=max_keyframes)
    keyframes, reference = KeyframeMap(0.03, np.eye(3), settings), None
    for number in range(count):
        place = at(0, 0, 0.002 * number, 0.1 * np.sin(number), 0.1 * np.cos(number), 0)
        reference = keyframes.add(AHEAD, corner(rng), place, reference).number
        if registering:
            keyframes.process_pending()
    return keyframes


def parts(factors: tuple[BetweenFactor, ...], numbers: set[int]) -> int:
    """Number of connected parts of a graph."""
    part = {number: number for number in numbers}
    for factor in factors:
        one, other = part[factor.first], part[factor.second]
        part = {number: one if root == other else root for number, root in part.items()}
    return len(set(part.values()))


def numbers(keyframes: KeyframeMap) -> set[int]:
    return set(keyframes._graph.numbers)


def test_keyframes_factors_and_pending_pairs_stay_few() -> None:
    keyframes = loops_of_keyframes(max_keyframes=6, count=60)
    assert len(keyframes) == len(keyframes.poses) == 6
    assert len(keyframes.factors) <= 6 * 5 / 2
    assert len(keyframes._pending) <= 6 * 5
    assert {end for pair in keyframes._pending for end in pair} <= numbers(keyframes)
    # Frames at a culled keyframe keep their places.
    for number in range(60):
        keyframes.pose_of(number, np.eye(4))


@pytest.mark.parametrize("registering", [True, False])
def test_the_graph_stays_connected_though_pairs_are_pending(registering: bool) -> None:
    """A robot with few frames between its keyframes: what is culled was not registered yet."""
    keyframes = loops_of_keyframes(max_keyframes=6, count=24, registering=registering)
    keyframes.finalise()
    assert parts(keyframes.factors, numbers(keyframes)) == 1


def test_the_bound_leaves_room_for_the_factors_of_a_keyframe() -> None:
    assert len(COVISIBILITY_GAPS) + 1 < MAX_FACTORS_PER_KEYFRAME


def test_the_surface_of_all_keyframes_is_that_of_one_after_the_other() -> None:
    keyframes = loops_of_keyframes(99, 2 * MERGED_TOGETHER + 1, registering=False)
    one_by_one = SurfaceMap(0.03)
    for number in range(len(keyframes)):
        T = RigidTransform.from_matrix(keyframes[number].T_map_camera)
        one_by_one = one_by_one.with_surface(keyframes[number].surface, T)
    keyframes._merge_surfaces()
    merged = keyframes.surface_map
    np.testing.assert_array_equal(merged.sums.keys, one_by_one.sums.keys)
    np.testing.assert_allclose(merged.sums.totals, one_by_one.sums.totals, rtol=1e-9, atol=1e-6)


def test_one_pair_is_registered_at_a_time_unless_many_are_pending(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    registered: list[tuple[int, int]] = []
    monkeypatch.setattr(keyframe_map, "registered", lambda one, other, *_: registered.append(
        (one.number, other.number)))  # fmt: skip
    keyframes = loops_of_keyframes(max_keyframes=99, count=3, registering=False)
    for waiting, done in ((1, 1), (keyframe_map.MAX_PENDING + 1, 2)):
        registered.clear()
        keyframes._pending.clear()
        keyframes._pending.extend([(0, 2)] * waiting)
        keyframes.process_pending()
        assert len(registered) == done


def on_a_line(places: list[float]) -> KeyframeMap:
    rng = np.random.default_rng(0)
    keyframes, reference = KeyframeMap(0.03, np.eye(3)), None
    for x in places:
        reference = keyframes.add(AHEAD, corner(rng), at(0, 0, 0, x, 0, 0), reference).number
    keyframes._pending.clear()
    return keyframes


def test_a_returning_camera_is_referenced_to_recent_keyframes_until_a_loop_closes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there_and_back = [0.3 * n for n in [*range(10), *range(9, 0, -1)]]
    keyframes, last = on_a_line(there_and_back), len(there_and_back) - 1
    pose = at(0, 0, 0, 0.05, 0, 0)
    assert keyframes.reference(pose.T_map_camera, last) == last
    variance = np.trace(keyframes.covariance(pose, last)[3:, 3:])
    assert variance > 8 * np.trace(STEP[3:, 3:])

    def loop(first, second, *_) -> BetweenFactor:
        T = RigidTransform.from_matrix(first.relative_pose(second.T_map_camera))
        return BetweenFactor(first.number, second.number, T, 1e4 * np.eye(6), robust=True)

    monkeypatch.setattr(keyframe_map, "registered", loop)
    assert last > LOOP_GAP
    keyframes._pending.append((0, last))
    keyframes.finalise()
    assert keyframes.reference(pose.T_map_camera, last) == 0
    assert np.trace(keyframes.covariance(pose, 0)[3:, 3:]) < 4 * np.trace(STEP[3:, 3:])


def test_a_relocalised_camera_is_referenced_to_the_nearest_keyframe() -> None:
    keyframes = on_a_line([0.3 * n for n in range(20)])
    assert keyframes.reference(np.eye(4), 19) == 18
    assert keyframes.reference(np.eye(4), None) == 0


def test_covariances_of_a_chain_are_those_of_the_drive_after_optimisation() -> None:
    keyframes = on_a_line([0.3 * n for n in range(12)])
    before = [keyframes[number].covariance for number in range(12)]
    keyframes.optimise(anyway=True)
    for number, covariance in enumerate(before):
        np.testing.assert_allclose(keyframes[number].covariance, covariance, rtol=1e-3, atol=1e-7)


def test_position_is_uncertain_until_a_loop_is_closed() -> None:
    tracker = Tracker()
    tracked = follow(drive(np.radians(np.arange(45, 430, 5.0))), tracker)
    variances = [float(np.trace(estimate.covariance[3:, 3:])) for estimate in tracked]
    widest = int(np.argmax(variances))
    assert any(abs(factor.first - factor.second) > LOOP_GAP for factor in tracker.keyframes.factors)
    assert variances[widest] > 1.5 * variances[0]
    assert min(variances[widest:]) < 0.8 * variances[widest]
