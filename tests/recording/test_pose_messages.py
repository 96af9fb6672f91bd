"""Odometry and transforms in messages of ROS."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.recording.odometry_buffer import OdometryBuffer
from circumspect.recording.pose_messages import (
    odometry_message,
    odometry_of,
    transform_message,
    transform_of,
    transforms_message,
)
from circumspect.recording.ros_time import header, nanoseconds
from circumspect.recording.transform_tree import TransformTree
from circumspect.sensing import Odometry

PLACES = st.floats(-100, 100)
STAMPS = st.floats(0, 2e9)
MOUNT = RigidTransform.from_components([0.1, 0.2, 1.0], Rotation.from_rotvec([0.4, -1.2, 0.3]))


@given(PLACES, PLACES, st.floats(-3.1, 3.1), STAMPS, st.integers(0, 2**31))
def test_odometry_comes_back(x: float, y: float, yaw: float, stamp: float, seed: int) -> None:
    half = np.random.default_rng(seed).normal(size=(3, 3))
    told = Odometry(stamp, PlanarPose(x, y, yaw), half @ half.T, 0.1, -0.2)
    found = odometry_of(odometry_message(told, "odom", "base_link"))
    assert found.T_odom_base.xy == pytest.approx([x, y])
    assert found.T_odom_base.yaw == pytest.approx(yaw, abs=1e-12)
    assert found.stamp == pytest.approx(stamp, abs=1e-6)
    np.testing.assert_allclose(found.covariance, told.covariance)
    assert (found.forward, found.turn) == (0.1, -0.2)
    # What was recorded once is not changed by being recorded again.
    again = odometry_of(odometry_message(found, "odom", "base_link"))
    assert again.stamp == found.stamp


@pytest.mark.parametrize("fault", ["quaternion", "place", "covariance"])
def test_odometry_that_makes_no_sense_is_refused(fault: str) -> None:
    told = odometry_message(Odometry(1.0, PlanarPose()), "odom", "base_link")
    if fault == "quaternion":
        told.pose.pose.orientation.w = 0.0
    elif fault == "place":
        told.pose.pose.position.x = np.nan
    else:
        told.pose.covariance[0] = np.inf
    with pytest.raises(InputError):
        odometry_of(told)


@pytest.mark.parametrize("stamp", [-0.1, 2.0**31, 1e300])
def test_times_that_ros_can_not_tell_are_refused(stamp: float) -> None:
    with pytest.raises(InputError, match="can not be recorded"):
        header(stamp, "map")


@given(STAMPS)
def test_stamps_are_kept_to_the_nanosecond(stamp: float) -> None:
    assert nanoseconds(nanoseconds(stamp) / 1e9) == nanoseconds(stamp)


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


def test_transforms_are_those_of_the_time_that_is_asked_for() -> None:
    tree = TransformTree()
    mount = transform_message(MOUNT, 0.0, "base", "camera")
    tree.heard(transforms_message([mount]))
    for k in range(31):
        one = transform_message(moving(0.05 * k), 0.05 * k, "map", "base")
        tree.heard(transforms_message([one]))
    for stamp in (0.72, 1.0, 1.26, 1.5):
        found = tree.between("map", "camera", stamp)
        assert found is not None
        np.testing.assert_allclose(
            found.as_matrix(), (moving(stamp) * MOUNT).as_matrix(), atol=1e-9
        )
    last = tree.between("map", "camera", 9.0)
    assert last is not None
    np.testing.assert_allclose(last.as_matrix(), (moving(1.5) * MOUNT).as_matrix(), atol=1e-9)
    assert tree.awaits("map", "camera", 1.51)
    assert not tree.awaits("map", "camera", 1.5)
    assert not tree.awaits("base", "camera", 1.51), "a mount does not move"
    late = transform_message(MOUNT, 1.2, "map", "base")
    tree.heard(transforms_message([late]))
    assert tree.awaits("map", "camera", 1.51), "what comes late changes nothing"


def test_after_a_leap_of_the_clock_the_last_transforms_hold_until_others_come() -> None:
    tree = TransformTree()
    for stamp in (100.0, 100.1):
        tree.heard(transforms_message([transform_message(moving(stamp), stamp, "map", "base")]))
    tree.begin_anew()
    found = tree.between("map", "base", 3.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), moving(100.1).as_matrix(), atol=1e-9)
    tree.heard(transforms_message([transform_message(moving(3.0), 3.0, "map", "base")]))
    found = tree.between("map", "base", 3.0)
    assert found is not None
    np.testing.assert_allclose(found.as_matrix(), moving(3.0).as_matrix(), atol=1e-9)


def odometry(stamp: float) -> Odometry:
    return Odometry(stamp, PlanarPose(stamp, -2 * stamp, 3 * stamp), stamp * np.eye(3), 0.1, 0.2)


def test_between_messages_the_odometry_is_in_between() -> None:
    buffer = OdometryBuffer()
    for stamp in (1.0, 1.1, 1.2):
        buffer.heard(odometry(stamp))
    buffer.heard(odometry(1.15))  # late: left out
    found = buffer.at(1.125)
    assert found is not None
    assert found.T_odom_base.xy == pytest.approx([1.125, -2.25])
    np.testing.assert_allclose(found.covariance, 1.125 * np.eye(3))
    turned = (found.T_odom_base.yaw - 3.375 + np.pi) % (2 * np.pi) - np.pi
    assert abs(turned) < 1e-9
    exact = buffer.at(1.1)
    assert exact is not None
    assert exact.T_odom_base == odometry(1.1).T_odom_base
    assert buffer.at(1.45) is None
    nearest = buffer.at(1.3)
    assert nearest is not None
    assert nearest.stamp == 1.2
    assert buffer.reaches(1.2)
    assert not buffer.reaches(1.21)


def test_old_odometry_is_forgotten() -> None:
    buffer = OdometryBuffer()
    for number in range(1000):
        buffer.heard(odometry(0.1 * number))
    assert buffer.at(50.0) is None
    assert buffer.at(95.0) is not None


@pytest.mark.parametrize("far", [1e308, float("inf"), float("nan")])
def test_absurd_numbers_are_refused_without_a_warning(far: float) -> None:
    place, orientation = SimpleNamespace(x=far, y=0, z=0), SimpleNamespace(x=far, y=0, z=0, w=1)
    with pytest.raises(InputError, match="a pose at"):
        transform_of(place, orientation)
