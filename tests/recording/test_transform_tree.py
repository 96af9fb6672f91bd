"""Frames and how they lie in each other: found along the tree, at the time that is asked for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.recording.pose_messages import (
    transform_message,
    transform_of,
    transforms_message,
)
from circumspect.recording.transform_tree import TransformTree

MOUNT = RigidTransform.from_components([0.1, 0.2, 1.0], Rotation.from_rotvec([0.4, -1.2, 0.3]))


def random_pose(rng: np.random.Generator) -> RigidTransform:
    return RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))


def test_transforms_are_found_along_the_tree() -> None:
    rng = np.random.default_rng(3)
    links = {("map", "odom"): random_pose(rng), ("odom", "base"): random_pose(rng),
             ("base", "mast"): random_pose(rng), ("mast", "camera"): random_pose(rng),
             ("base", "laser"): random_pose(rng)}  # fmt: skip
    tree = TransformTree()
    tree.heard(transforms_message([transform_message(T, 0.0, *n) for n, T in links.items()]))
    expected = links["base", "laser"].inv() * links["base", "mast"] * links["mast", "camera"]
    found = tree.between("/laser", "camera", 0.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), expected.as_matrix(), atol=1e-12)
    assert tree.between("laser", "elsewhere", 0.0) is None
    direct, link = tree.between("base", "mast", 0.0), links["base", "mast"]
    assert direct is not None
    told = transform_message(link, 0.0, "base", "mast").transform
    as_told = transform_of(told.translation, told.rotation)
    np.testing.assert_array_equal(direct.as_matrix(), as_told.as_matrix(), "not even rounded")


@pytest.mark.parametrize("parent", ["base", "elsewhere"])
def test_static_transforms_stay_static(parent: str) -> None:
    """A flipped bit, or a second publisher, names the camera on /tf as well."""
    rng = np.random.default_rng(4)
    tree, mount = TransformTree(), random_pose(rng)
    tree.heard(transforms_message([transform_message(mount, 0.0, "base", "camera")]), lasting=True)
    for stamp in (1.0, 2.0):
        other = transform_message(random_pose(rng), stamp, parent, "camera")
        tree.heard(transforms_message([other]))
    for stamp in (0.0, 1.5, 100.0):
        found = tree.between("base", "camera", stamp)
        assert found is not None
        np.testing.assert_allclose(found.as_matrix(), mount.as_matrix(), atol=1e-12)
    corrected = random_pose(rng)
    tree.heard(
        transforms_message([transform_message(corrected, 3.0, "base", "camera")]), lasting=True
    )
    found = tree.between("base", "camera", 100.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), corrected.as_matrix(), atol=1e-12)


def test_a_loop_of_transforms_ends() -> None:
    tree, T = TransformTree(), RigidTransform.identity()
    names = [("a", "b"), ("b", "c"), ("c", "a")]
    tree.heard(transforms_message([transform_message(T, 0.0, *n) for n in names]))
    assert tree.between("x", "a", 0.0) is None
    assert tree.between("a", "c", 0.0) is not None


def moving(stamp: float) -> RigidTransform:
    """An even arc."""
    turn = Rotation.from_rotvec([0.0, 0.0, 0.6 * stamp])
    centre = RigidTransform.from_translation([1.0, 2.0, 0.0])
    return centre * RigidTransform.from_rotation(turn) * centre.inv()


def tell(
    tree: TransformTree, T: RigidTransform, stamp: float, parent: str, child: str,
    lasting: bool = False,
) -> None:  # fmt: skip
    tree.heard(transforms_message([transform_message(T, stamp, parent, child)]), lasting)


def driving(interval: float, until: float, start: float = 0.0) -> TransformTree:
    """A robot whose place is told at some interval [s] up to a time [s], with a camera."""
    tree = TransformTree()
    tell(tree, MOUNT, start, "base", "camera")
    for k in range(round((until - start) / interval) + 1):
        stamp = start + interval * k
        tell(tree, moving(stamp), stamp, "map", "base")
    return tree


def assert_at(tree: TransformTree, stamp: float, T_map_base: RigidTransform) -> None:
    found = tree.between("map", "camera", stamp)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), (T_map_base * MOUNT).as_matrix(), atol=1e-6)


@given(st.floats(0.01, 0.5), st.floats(0, 1))
def test_between_two_transforms_a_motion_is_even(interval: float, share: float) -> None:
    stamp = interval * (3 + share)
    assert_at(driving(interval, 6 * interval), stamp, moving(stamp))


@pytest.mark.parametrize("interval", [0.05, 0.3])
def test_where_a_robot_is_may_still_be_told(interval: float) -> None:
    tree = driving(interval, 1.5)
    assert tree.awaits("map", "camera", 1.51)
    assert not tree.awaits("map", "camera", 1.5)
    assert not tree.awaits("base", "camera", 1.51), "a mount does not move"
    tell(tree, MOUNT, 1.2, "map", "base")
    assert tree.awaits("map", "camera", 1.51), "what comes late changes nothing"
    assert_at(tree, 1.5, moving(1.5))


@pytest.mark.parametrize(("interval", "lasts"), [(0.02, 0.2), (0.1, 0.2), (0.5, 1.0), (2.0, 4.0)])
def test_what_moved_is_known_only_for_a_while(interval: float, lasts: float) -> None:
    """Where a localization died while the robot drives on, nobody knows where it is."""
    tree = driving(interval, 10.0)
    assert_at(tree, 10.0 + 0.95 * lasts, moving(10.0))
    assert tree.between("map", "camera", 10.0 + 1.05 * lasts) is None
    assert tree.between("base", "camera", 1e6) is not None, "the mount stays"


@pytest.mark.parametrize("interval", [10.5, 15.0, 100.0])
def test_what_is_told_rarely_lasts_long(interval: float) -> None:
    tree = driving(interval, interval)
    assert_at(tree, 2.9 * interval, moving(interval))
    assert tree.between("map", "camera", 3.1 * interval) is None


def test_what_moved_is_not_known_long_before_it_was_told() -> None:
    tree = driving(0.1, 10.0, start=5.0)
    assert_at(tree, 4.85, moving(5.0))
    assert tree.between("map", "camera", 4.7) is None


def test_across_a_gap_nothing_is_known() -> None:
    tree = driving(0.1, 3.0)
    for stamp in (26.0, 26.1):
        tell(tree, moving(stamp), stamp, "map", "base")
    assert tree.between("map", "camera", 20.0) is None
    assert_at(tree, 25.9, moving(26.0))
    assert_at(tree, 26.05, moving(26.05))


def test_an_image_that_comes_late_is_placed_where_it_was_taken() -> None:
    tree = driving(0.1, 10.0)
    assert_at(tree, 1.04, moving(1.04))
    for k in range(200):
        tell(tree, moving(10.1 + 0.1 * k), 10.1 + 0.1 * k, "map", "base")
    assert tree.between("map", "camera", 1.04) is None, "that is forgotten"


@pytest.mark.parametrize("times", [1, 2, 50])
def test_what_never_moved_stays_where_it_was_told(times: int) -> None:
    tree = TransformTree()
    for k in range(times):
        tell(tree, MOUNT, 5 + 0.1 * k, "map", "camera")
    told = transform_message(MOUNT, 0.0, "map", "camera").transform
    for stamp in (0.0, 5.0, 5.11, 1e4):
        found = tree.between("map", "camera", stamp)
        assert found is not None
        as_told = transform_of(told.translation, told.rotation)
        np.testing.assert_array_equal(found.as_matrix(), as_told.as_matrix(), "not even rounded")


def test_what_is_told_for_good_holds_until_another_is_told() -> None:
    tree, lower = TransformTree(), RigidTransform.from_translation([0.0, 0.0, 0.5])
    tell(tree, MOUNT, 1.0, "base", "camera", lasting=True)
    for stamp in (2.0, 2.1, 2.2):
        tell(tree, lower, stamp, "base", "camera", lasting=True)
    for stamp, T in ((0.5, MOUNT), (1.9, MOUNT), (2.05, lower), (1e4, lower)):
        found = tree.between("base", "camera", stamp)
        assert found is not None
        np.testing.assert_allclose(found.as_matrix(), T.as_matrix(), atol=1e-12)


def test_one_that_begins_to_move_is_known_while_it_is_told() -> None:
    tree = TransformTree()
    tell(tree, MOUNT, 0.0, "base", "camera")
    for k in range(100):
        tell(tree, moving(0.0), 0.1 * k, "map", "base")
    assert_at(tree, 60.0, moving(0.0))
    for stamp in (10.0, 10.1):
        tell(tree, moving(stamp), stamp, "map", "base")
    for stamp in (3.0, 9.4, 9.85):  # images that come late
        assert_at(tree, stamp, moving(0.0))
    assert_at(tree, 10.05, moving(10.05))
    assert tree.between("map", "camera", 60.0) is None


def test_after_a_leap_of_the_clock_only_what_does_not_move_holds() -> None:
    tree = driving(0.1, 100.1, start=99.0)
    tree.begin_anew()
    assert tree.between("map", "camera", 3.0) is None
    assert tree.between("base", "camera", 3.0) is not None
    tell(tree, moving(3.0), 3.0, "map", "base")
    assert_at(tree, 3.0, moving(3.0))
    tell(tree, moving(3.1), 3.1, "map", "base")
    assert_at(tree, 3.05, moving(3.05))
