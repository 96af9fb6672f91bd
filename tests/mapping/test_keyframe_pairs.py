"""Which keyframes are fitted to each other, and what such a fit is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import T_BASE_CAMERA, drive, true_base, true_camera

from circumspect.geometry import PlanarPose, se3
from circumspect.mapping import TrackingSettings
from circumspect.mapping.keyframe import Keyframe
from circumspect.mapping.keyframe_pairs import (
    along,
    by_tracking,
    joined,
    pair_edge,
    showing_the_same,
    worth_by_view,
)
from circumspect.mapping.keyframes import Keyframes
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.mapping.wheel_motion import WheelMotion, wheel_step
from circumspect.mapping.wheels import Passage
from circumspect.registration import Scan
from circumspect.sensing import Odometry

I6 = np.eye(6)
SETTINGS = TrackingSettings()


def keyframe(number: int, angle: float, stretch: int = 0, off: float = 0.0) -> Keyframe:
    """Taken at an angle [rad] of the drive, believed `off` [m] from there."""
    frame = drive(np.array([angle]))[0]
    T = true_camera(angle) * RigidTransform.from_translation([off, 0.0, 0.0])
    return Keyframe.of(number, T, 1e-6 * I6, Scan.from_frame(frame), frame, Passage(stretch))


def fitted(one: Keyframe, other: Keyframe):
    return pair_edge(one, other, 0.03, SETTINGS.registration, SETTINGS.gate, WheelGrip())


def driven(T_old_new: RigidTransform, covariance: np.ndarray) -> WheelMotion:
    """What wheels told that grip fully."""
    return replace(WheelMotion.none(), T_old_new=T_old_new, noise=covariance)


def error_of(edge, first: float, second: float) -> float:
    true = true_camera(first).inv() * true_camera(second)
    return float(np.linalg.norm((true.inv() * edge.T_first_second).translation))


@given(st.integers(0, 2**32 - 1), st.floats(0, 2), st.integers(1, 6))
def test_no_fit_is_worth_more_than_it_says(seed: int, turn: float, rank: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(6, rank)) * 100
    information = A @ A.T
    near = worth_by_view(information, se3.exp([0, 0.1 * turn, 0, 0.1, 0, 0]))
    far = worth_by_view(information, se3.exp([0, turn, 0, 0.1, 0, 0]))
    scale = 1e-6 * np.abs(information).max() + 1e-2
    for less, more in ((near, information), (far, near), (np.zeros((6, 6)), far)):
        assert np.linalg.eigvalsh(more - less).min() > -scale


def test_of_views_that_look_alike_the_fit_is_kept() -> None:
    information = np.diag([1e6, 1e6, 1e6, 1e5, 1e5, 1e5])
    kept = worth_by_view(information, RigidTransform.from_translation([0.3, 0, 0]))
    np.testing.assert_allclose(kept, information, rtol=0.3)


def test_keyframes_that_show_the_other_side_are_left_out() -> None:
    others = [keyframe(number, np.radians(angle)) for number, angle in enumerate((45, 135, 225))]
    poses = np.stack([other.T_map_camera.as_matrix() for other in others])
    assert showing_the_same(keyframe(30, np.radians(50)), others, poses) == [0]
    assert showing_the_same(keyframe(30, np.radians(225)), others, poses) == [2]


def test_a_loop_is_measured_whatever_the_drift() -> None:
    first, second = np.radians(45.0), np.radians(48.0)
    edge = fitted(keyframe(0, first), keyframe(30, second, stretch=4, off=0.03))
    assert edge is not None
    assert edge.robust
    assert error_of(edge, first, second) < 0.01


def test_where_the_scene_let_go_the_wheels_link_keyframes() -> None:
    """Nothing of the second view lies on the first; tracking was 0.1 m off, the wheels 2 mm."""
    first, second = np.radians(45.0), np.radians(135.0)
    true = true_camera(first).inv() * true_camera(second)
    by_wheels = driven(true * RigidTransform.from_translation([0.002, 0, 0]), 1e-5 * I6)
    other = keyframe(1, second, off=0.1)
    lost = replace(other, passage=Passage(1, by_wheels))
    edge = fitted(keyframe(0, first), lost)
    assert edge is not None
    assert not edge.robust, "the chain of the drive"
    assert error_of(edge, first, second) < 0.01
    alone = fitted(keyframe(0, first), replace(other, passage=Passage(1)))
    assert alone is not None
    assert error_of(alone, first, second) > 0.05
    assert np.linalg.eigvalsh(alone.information)[0] < 1e3, "which is worth little"


def test_a_grip_learnt_later_moves_what_the_wheels_alone_linked() -> None:
    """The second keyframe shows nothing of the first, and a twentieth of the way was slip."""
    first, second = np.radians(45.0), np.radians(135.0)
    told = true_base(first).inverse() @ true_base(second)
    told = PlanarPose(told.x / 0.95, told.y / 0.95, told.yaw)
    by_wheels = wheel_step(
        Odometry(0.0, PlanarPose()), Odometry(1.0, told), 2 * (T_BASE_CAMERA,), SETTINGS.motion
    )
    keys = Keyframes(
        0.03, SETTINGS.keyframes, SETTINGS.registration, SETTINGS.gate, np.diag([1e4, 1e4, 1e4])
    )
    for angle, passage in ((first, Passage()), (second, Passage(1, by_wheels))):
        frame = drive(np.array([angle]))[0]
        keys.add(true_camera(angle), 1e-6 * I6, Scan.from_frame(frame), frame, passage)
    keys.fit_next()
    (before,) = keys.graph().between_factors
    keys.grip = WheelGrip((4.0, 6.0), (0.95 * 4.0, 6.0))
    keys.fit_what_wheels_held()
    (after,) = keys.graph().between_factors
    assert error_of(before, first, second) > 0.06
    assert error_of(after, first, second) < 0.02


def test_tracking_is_worth_what_the_scene_held_of_it() -> None:
    one = keyframe(0, np.radians(45.0))
    held = np.diag([1e9, 1e9, 1e9, 0.01**-2, 1e9, 0.0])
    near, far = (
        replace(keyframe(number, np.radians(48.0)), number=number, passage=Passage(0, None, held))
        for number in (1, 4)
    )
    covariance = np.linalg.inv(by_tracking(one, near) + 1e-6 * I6)
    assert np.sqrt(covariance[4, 4]) == pytest.approx(0.0005, rel=0.1)
    assert np.sqrt(covariance[3, 3]) == pytest.approx(0.015, rel=0.1)
    assert np.sqrt(covariance[5, 5]) > 10, "nothing is known of it"
    np.testing.assert_allclose(by_tracking(one, far), by_tracking(one, near) / 4)
    alone = by_tracking(one, keyframe(1, np.radians(48.0)))
    assert np.sqrt(1 / alone[3, 3]) == pytest.approx(0.0005)


def test_where_the_scene_held_the_heading_it_is_kept() -> None:
    """The wheels turned 2° too little; a wall all along told the heading, but not the way."""
    first, second = np.radians(45.0), np.radians(135.0)
    true = true_camera(first).inv() * true_camera(second)
    by_wheels = driven(true * se3.exp(np.array([0, np.radians(2.0), 0, 0.01, 0, 0])), 1e-5 * I6)
    by_scene = np.diag([1e8, 1e8, 1e8, 0.0, 1e6, 1e6])
    key = replace(keyframe(1, second, off=0.1), passage=Passage(1, by_wheels, by_scene))
    edge = fitted(keyframe(0, first), key)
    assert edge is not None
    error = se3.log(true.inv() * edge.T_first_second)
    assert np.degrees(np.linalg.norm(error[:3])) < 0.1
    assert abs(error[3]) < 0.015, "the way is that of the wheels"


def test_where_the_camera_leapt_the_wheels_link_keyframes_but_may_be_let_go() -> None:
    """The map had gone wrong by 0.1 m, and the last frames were fitted to an older part of it."""
    first, second = np.radians(45.0), np.radians(135.0)
    true = true_camera(first).inv() * true_camera(second)
    by_wheels = driven(true * RigidTransform.from_translation([0.002, 0, 0]), 1e-5 * I6)
    key = replace(keyframe(1, second, off=0.1), passage=Passage(1, by_wheels, broken=True))
    edge = fitted(keyframe(0, first), key)
    assert edge is not None
    assert edge.robust, "it may have been carried"
    assert error_of(edge, first, second) < 0.01


@pytest.mark.parametrize(("turned", "believed"), [(15.0, True), (90.0, False)])
def test_found_again_where_the_wheels_may_lead_is_believed(turned: float, believed: bool) -> None:
    """After long blind turns the wheels are 15° off, and know that they may be; 90° is a leap."""
    unsure = np.diag([np.radians(8.0)] * 3 + [0.1] * 3) ** 2
    off = se3.exp(np.array([0, np.radians(turned), 0, 0, 0, 0]))
    passage = Passage(1, driven(off, unsure), broken=True)
    T, information = along(passage, RigidTransform.identity(), SETTINGS.gate, WheelGrip())
    assert np.degrees(T.rotation.magnitude()) == pytest.approx(0.0 if believed else turned)
    wheels_alone = np.linalg.inv(unsure)
    assert np.allclose(information, wheels_alone) != believed


def rotations_and_ways():
    return st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6).map(np.array)


@given(rotations_and_ways(), st.floats(1.0, 1e4), st.floats(1.0, 1e4))
def test_joined_measurements_lie_between(change, one: float, other: float) -> None:
    T = se3.exp(np.array([0.1, -0.2, 0.3, 1.0, 2.0, 3.0]))
    found, known = joined(T, one * I6, T * se3.exp(change), other * I6)
    share = other / (one + other)
    np.testing.assert_allclose(se3.log(T.inv() * found), share * change, atol=1e-9)
    np.testing.assert_allclose(known, (one + other) * I6)


def test_what_has_nothing_in_common_is_not_linked() -> None:
    assert fitted(keyframe(0, np.radians(45.0)), keyframe(30, np.radians(225.0))) is None


def test_a_keyframe_knows_what_it_looked_through() -> None:
    key = keyframe(0, np.radians(45.0))
    half_way = key.T_map_camera.apply(np.array([[0.0, 0.0, 0.7]]))
    assert key.looks_through(half_way)[0]
    assert not key.looks_through(key.T_map_camera.apply(np.array([[0.0, 0.0, -0.7]])))[0]
    on_it = key.T_map_camera.apply(key.surface.scan.points_xyz)
    assert key.looks_through(on_it).mean() < 0.02
