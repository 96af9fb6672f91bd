"""Transforms between frames along the tree, at the requested time."""

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
    tree.add(transforms_message([transform_message(T, 0.0, *n) for n, T in links.items()]))
    expected = links["base", "laser"].inv() * links["base", "mast"] * links["mast", "camera"]
    found = tree.between("/laser", "camera", 0.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), expected.as_matrix(), atol=1e-12)
    assert tree.between("laser", "elsewhere", 0.0) is None
    direct, link = tree.between("base", "mast", 0.0), links["base", "mast"]
    assert direct is not None
    msg = transform_message(link, 0.0, "base", "mast").transform
    recorded_transform = transform_of(msg.translation, msg.rotation)
    np.testing.assert_array_equal(
        direct.as_matrix(), recorded_transform.as_matrix(), "not even rounded"
    )


@pytest.mark.parametrize("parent", ["base", "elsewhere"])
def test_static_transforms_stay_static(parent: str) -> None:
    """A flipped bit, or a second publisher, names the camera on /tf as well."""
    rng = np.random.default_rng(4)
    tree, mount = TransformTree(), random_pose(rng)
    tree.add(transforms_message([transform_message(mount, 0.0, "base", "camera")]), static=True)
    for stamp in (1.0, 2.0):
        other = transform_message(random_pose(rng), stamp, parent, "camera")
        tree.add(transforms_message([other]))
    for stamp in (0.0, 1.5, 100.0):
        found = tree.between("base", "camera", stamp)
        assert found is not None
        np.testing.assert_allclose(found.as_matrix(), mount.as_matrix(), atol=1e-12)
    corrected = random_pose(rng)
    tree.add(transforms_message([transform_message(corrected, 3.0, "base", "camera")]), static=True)
    found = tree.between("base", "camera", 100.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), corrected.as_matrix(), atol=1e-12)


def test_a_loop_of_transforms_terminates() -> None:
    tree, T = TransformTree(), RigidTransform.identity()
    names = [("a", "b"), ("b", "c"), ("c", "a")]
    tree.add(transforms_message([transform_message(T, 0.0, *n) for n in names]))
    assert tree.between("x", "a", 0.0) is None
    assert tree.between("a", "c", 0.0) is not None


def moving(stamp: float) -> RigidTransform:
    """An even arc."""
    turn = Rotation.from_rotvec([0.0, 0.0, 0.6 * stamp])
    centre = RigidTransform.from_translation([1.0, 2.0, 0.0])
    return centre * RigidTransform.from_rotation(turn) * centre.inv()


def add_transform(
    tree: TransformTree, T: RigidTransform, stamp: float, parent: str, child: str,
    static: bool = False,
) -> None:  # fmt: skip
    tree.add(transforms_message([transform_message(T, stamp, parent, child)]), static)


def driving(interval: float, until: float, start: float = 0.0) -> TransformTree:
    """A robot with a camera; its pose is published at an interval [s] up to a time [s]."""
    tree = TransformTree()
    add_transform(tree, MOUNT, start, "base", "camera")
    for k in range(round((until - start) / interval) + 1):
        stamp = start + interval * k
        add_transform(tree, moving(stamp), stamp, "map", "base")
    return tree


def assert_at(tree: TransformTree, stamp: float, T_map_base: RigidTransform) -> None:
    found = tree.between("map", "camera", stamp)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), (T_map_base * MOUNT).as_matrix(), atol=1e-6)


@given(st.floats(0.01, 0.5), st.floats(0, 1))
def test_transforms_are_interpolated_along_an_arc(interval: float, share: float) -> None:
    stamp = interval * (3 + share)
    assert_at(driving(interval, 6 * interval), stamp, moving(stamp))


@pytest.mark.parametrize("interval", [0.05, 0.3])
def test_a_moving_pose_is_pending_after_its_last_transform(interval: float) -> None:
    tree = driving(interval, 1.5)
    assert tree.is_pending("map", "camera", 1.51)
    assert not tree.is_pending("map", "camera", 1.5)
    assert not tree.is_pending("base", "camera", 1.51), "a mount does not move"
    add_transform(tree, MOUNT, 1.2, "map", "base")
    assert tree.is_pending("map", "camera", 1.51), "late transforms are ignored"
    assert_at(tree, 1.5, moving(1.5))


@pytest.mark.parametrize(("interval", "lasts"), [(0.02, 0.2), (0.1, 0.2), (0.5, 1.0), (2.0, 4.0)])
def test_a_moving_transform_expires(interval: float, lasts: float) -> None:
    """The pose is unknown when the localization stops while the robot drives on."""
    tree = driving(interval, 10.0)
    assert_at(tree, 10.0 + 0.95 * lasts, moving(10.0))
    assert tree.between("map", "camera", 10.0 + 1.05 * lasts) is None
    assert tree.between("base", "camera", 1e6) is not None, "the mount stays"


@pytest.mark.parametrize("interval", [10.5, 15.0, 100.0])
def test_a_rarely_published_transform_lasts_longer(interval: float) -> None:
    tree = driving(interval, interval)
    assert_at(tree, 2.9 * interval, moving(interval))
    assert tree.between("map", "camera", 3.1 * interval) is None


def test_a_moving_transform_is_unknown_long_before_its_first_stamp() -> None:
    tree = driving(0.1, 10.0, start=5.0)
    assert_at(tree, 4.85, moving(5.0))
    assert tree.between("map", "camera", 4.7) is None


def test_no_transform_within_a_gap() -> None:
    tree = driving(0.1, 3.0)
    for stamp in (26.0, 26.1):
        add_transform(tree, moving(stamp), stamp, "map", "base")
    assert tree.between("map", "camera", 20.0) is None
    assert_at(tree, 25.9, moving(26.0))
    assert_at(tree, 26.05, moving(26.05))


def test_a_late_image_gets_the_pose_of_its_stamp() -> None:
    tree = driving(0.1, 10.0)
    assert_at(tree, 1.04, moving(1.04))
    for k in range(200):
        add_transform(tree, moving(10.1 + 0.1 * k), 10.1 + 0.1 * k, "map", "base")
    assert tree.between("map", "camera", 1.04) is None, "dropped by then"


@pytest.mark.parametrize("times", [1, 2, 50])
def test_a_constant_transform_holds_at_all_times(times: int) -> None:
    tree = TransformTree()
    for k in range(times):
        add_transform(tree, MOUNT, 5 + 0.1 * k, "map", "camera")
    msg = transform_message(MOUNT, 0.0, "map", "camera").transform
    for stamp in (0.0, 5.0, 5.11, 1e4):
        found = tree.between("map", "camera", stamp)
        assert found is not None
        recorded_transform = transform_of(msg.translation, msg.rotation)
        np.testing.assert_array_equal(
            found.as_matrix(), recorded_transform.as_matrix(), "not even rounded"
        )


def test_a_static_transform_holds_until_it_is_replaced() -> None:
    tree, lower = TransformTree(), RigidTransform.from_translation([0.0, 0.0, 0.5])
    add_transform(tree, MOUNT, 1.0, "base", "camera", static=True)
    for stamp in (2.0, 2.1, 2.2):
        add_transform(tree, lower, stamp, "base", "camera", static=True)
    for stamp, T in ((0.5, MOUNT), (1.9, MOUNT), (2.05, lower), (1e4, lower)):
        found = tree.between("base", "camera", stamp)
        assert found is not None
        np.testing.assert_allclose(found.as_matrix(), T.as_matrix(), atol=1e-12)


def test_a_transform_that_starts_to_move_is_interpolated_and_expires() -> None:
    tree = TransformTree()
    add_transform(tree, MOUNT, 0.0, "base", "camera")
    for k in range(100):
        add_transform(tree, moving(0.0), 0.1 * k, "map", "base")
    assert_at(tree, 60.0, moving(0.0))
    for stamp in (10.0, 10.1):
        add_transform(tree, moving(stamp), stamp, "map", "base")
    for stamp in (3.0, 9.4, 9.85):  # images that come late
        assert_at(tree, stamp, moving(0.0))
    assert_at(tree, 10.05, moving(10.05))
    assert tree.between("map", "camera", 60.0) is None


def test_a_clock_reset_keeps_only_constant_transforms() -> None:
    tree = driving(0.1, 100.1, start=99.0)
    tree.reset_clock()
    assert tree.between("map", "camera", 3.0) is None
    assert tree.between("base", "camera", 3.0) is not None
    add_transform(tree, moving(3.0), 3.0, "map", "base")
    assert_at(tree, 3.0, moving(3.0))
    add_transform(tree, moving(3.1), 3.1, "map", "base")
    assert_at(tree, 3.05, moving(3.05))
