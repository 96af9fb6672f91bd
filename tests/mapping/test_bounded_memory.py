"""However long a run, what the pose graph keeps stays bounded."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, se3
from circumspect.mapping import TrackingSettings
from circumspect.mapping.heirs import Heirs
from circumspect.mapping.keyframe_pairs import AGES
from circumspect.mapping.keyframes import EDGES_EACH, TOGETHER, Keyframes, KeyframeSettings
from circumspect.mapping.wheels import Passage
from circumspect.pose_graph import BetweenFactor
from circumspect.registration import Scan, SurfaceMap
from circumspect.sensing import RgbdFrame

I6 = np.eye(6)
AHEAD = RgbdFrame(np.full((24, 32), 2.0), PinholeCamera(32, 24, 24.0, 24.0, 15.5, 11.5), 0.0)


def corner(rng: np.random.Generator) -> Scan:
    """Points on three walls, as seen from a place; enough to be fitted."""
    flat = rng.uniform(0.0, 1.0, (3, 150, 2))
    walls = [np.insert(points, axis, 0.0, axis=1) for axis, points in enumerate(flat)]
    ahead = np.array([0.0, 0.0, 1.0])
    return Scan.with_white_noise(np.concatenate(walls) + ahead, np.full(450, 2e-3))


def rounds_of_keyframes(most: int, count: int, fitting: bool = True) -> Keyframes:
    s = TrackingSettings()
    rng, settings = np.random.default_rng(0), KeyframeSettings(most=most)
    keys = Keyframes(0.03, settings, s.registration, s.gate, np.eye(3))
    for number in range(count):
        place = se3.exp([0, 0, 0.002 * number, 0.1 * np.sin(number), 0.1 * np.cos(number), 0])
        keys.add(place, 1e-6 * I6, corner(rng), AHEAD, Passage())
        if fitting and len(keys.queue):
            keys.fit_next()
    return keys


def pieces(edges: Iterable[BetweenFactor], numbers: Iterable[int]) -> int:
    """Into how many parts a graph falls."""
    part = {number: number for number in numbers}
    for edge in edges:
        one, other = part[edge.first], part[edge.second]
        part = {number: one if at == other else at for number, at in part.items()}
    return len(set(part.values()))


def test_keyframes_edges_and_what_waits_stay_few() -> None:
    keys = rounds_of_keyframes(most=6, count=60)
    assert len(keys) == 6
    assert len(keys.graph().between_factors) <= 6 * 5 / 2
    assert len(keys.queue) <= 6 * 5
    # Whatever gave way is still placed by what stands for it.
    for number in range(60):
        keys.anchored(number, RigidTransform.identity())


@pytest.mark.parametrize("fitting", [True, False])
def test_the_graph_stays_in_one_piece_though_pairs_wait(fitting: bool) -> None:
    """A robot with few frames between its keyframes: what gives way was not fitted yet."""
    keys = rounds_of_keyframes(most=6, count=24, fitting=fitting)
    while len(keys.queue):
        keys.fit_next()
    assert pieces(keys.graph().between_factors, range(6)) == 1


def test_the_map_of_all_keyframes_is_that_of_each_laid_over_the_others() -> None:
    keys = rounds_of_keyframes(most=99, count=2 * TOGETHER + 1, fitting=False)
    one_by_one = SurfaceMap(0.03)
    for number in range(len(keys)):
        one_by_one = one_by_one.with_surface(keys[number].surface, keys[number].T_map_camera)
    scene = keys.scene()
    np.testing.assert_array_equal(scene.sums.keys, one_by_one.sums.keys)
    np.testing.assert_allclose(scene.sums.totals, one_by_one.sums.totals, rtol=1e-9, atol=1e-6)


def test_heirs_are_followed_and_the_oldest_forgotten() -> None:
    heirs, step = Heirs(most=3), se3.exp([0, 0, 0, 1.0, 0, 0])
    for number in range(3):
        heirs.gave_way(number, number + 1, step)
    number, T = heirs.living(0, RigidTransform.identity())
    assert number == 3
    np.testing.assert_allclose(T.translation, [3.0, 0, 0])
    for number in range(3, 50):
        heirs.gave_way(number, number + 1, step)
    assert len(heirs) == 3
    assert heirs.living(0, step)[0] == 0, "forgotten: it stands for itself"
    assert heirs.living(47, step)[0] == 50


def test_the_bound_leaves_room_for_what_a_keyframe_is_fitted_to() -> None:
    assert len(AGES) + 1 < EDGES_EACH
