"""What the wheels say between frames and between keyframes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform
from tracking_world import (
    SHORT,
    T_BASE_CAMERA,
    follow,
    place_errors,
    short_drive,
    true_camera,
)

from circumspect.geometry import PlanarPose
from circumspect.mapping.motion import Belief, MotionSettings
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.mapping.wheels import FARTHEST_STEP, Wheels
from circumspect.sensing import Odometry

LOOKING_AHEAD = RigidTransform.identity()
"""A camera whose axes are the robot's."""


def true_motion(number: int):
    return true_camera(float(SHORT[number - 1])).inv() * true_camera(float(SHORT[number]))


def listened(held: set[int], mute: frozenset[int] = frozenset()) -> tuple[Wheels, list]:
    """Wheels after a short drive in which the scene held some frames; a keyframe each fourth."""
    wheels, passages = Wheels(MotionSettings()), []
    for number, frame in enumerate(short_drive()):
        heard = replace(frame, odometry=None) if number in mute else frame
        wheels.heard(heard, true_motion(number) if number in held else None)
        if number % 4 == 0:
            passages.append(wheels.at_keyframe())
    return wheels, passages


def test_slip_is_learnt_where_the_scene_holds() -> None:
    wheels, _ = listened(set(range(1, 16)))
    way, turn = wheels.grip.shares
    assert 0.95 < way < 0.99
    assert 0.95 < turn < 1.0


def test_nothing_is_learnt_where_it_does_not() -> None:
    assert listened(set())[0].grip.shares == (1.0, 1.0)
    # One frame that is held says nothing without the one before it.
    assert listened({3, 6, 9})[0].grip.shares == (1.0, 1.0)


def along(steps: int, held: bool, grip: WheelGrip) -> float:
    """Standard deviation [m] of the way, after a metre straight ahead in so many steps."""
    wheels, covariance = Wheels(MotionSettings()), np.zeros((6, 6))
    wheels.grip = grip
    for number in range(steps + 1):
        odometry = Odometry(float(number), PlanarPose(number / steps, 0.0, 0.0))
        frame = replace(short_drive()[0], odometry=odometry, T_base_camera=LOOKING_AHEAD)
        if number > 0:
            covariance = covariance + wheels.step(frame).by(grip).covariance
        step = RigidTransform.from_translation([1 / steps, 0.0, 0.0])
        wheels.heard(frame, step if held else None)
    return float(np.sqrt(covariance[3, 3]))


def step_sigmas(covariances, poses) -> np.ndarray:
    """Standard deviations of turn and place after one step."""
    wheels, told = Wheels(MotionSettings()), []
    for number, (pose, covariance) in enumerate(zip(poses, covariances, strict=True)):
        odometry = Odometry(float(number), pose, covariance)
        frame = replace(short_drive()[0], odometry=odometry, T_base_camera=LOOKING_AHEAD)
        told.append(wheels.step(frame))
        wheels.heard(frame, None)
    assert told[-1] is not None
    return np.sqrt(np.diag(told[-1].by(wheels.grip).covariance))


def test_a_covariance_that_does_not_grow_as_dead_reckoning_does_tells_nothing() -> None:
    before, now = PlanarPose(2.0, 1.0, 0.3), PlanarPose(2.024, 1.007, 0.3)
    slip_alone = step_sigmas([np.zeros((3, 3))] * 2, [before, now])
    constant = np.diag([0.1, 0.1, 0.2])
    np.testing.assert_allclose(step_sigmas([constant] * 2, [before, now]), slip_alone)
    # Of another pose than it comes with: the same steps, but seen from elsewhere.
    first = Odometry(0.0, before, np.array([[0.2, 0.1, 0.1], [0.1, 0.4, -0.2], [0.1, -0.2, 0.3]]))
    noise = np.diag([0.01, 0.02, 0.03]) ** 2
    true = Odometry(1.0, now).grown_from(first, noise).covariance
    R = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = [R @ P @ R.T for P in (first.covariance, true)]
    np.testing.assert_allclose(step_sigmas(turned, [before, now]), slip_alone)
    # One that does is believed.
    believed = step_sigmas([first.covariance, true], [before, now])
    np.testing.assert_allclose(
        believed[[3, 4, 2]], np.hypot(slip_alone[[3, 4, 2]], [0.01, 0.02, 0.03])
    )


@pytest.mark.parametrize("steps", [1, 4, 40])
def test_steady_slip_costs_the_same_in_long_and_short_steps(steps: int) -> None:
    # A twentieth of the metre, and up to a millimetre a step.
    assert 0.05 <= along(steps, held=False, grip=WheelGrip()) < 0.053


def test_slip_is_steady_only_where_it_was_never_compared() -> None:
    unknown = along(40, held=False, grip=WheelGrip())
    known = along(40, held=False, grip=WheelGrip((6.0, 6.0), (5.8, 5.8)))
    held = along(40, held=True, grip=WheelGrip())
    assert known < 0.35 * unknown
    assert held < 0.35 * unknown


def test_a_passage_is_the_way_since_the_last_keyframe() -> None:
    wheels, passages = listened(set(range(1, 16)))
    assert passages[0].by_wheels is None, "nothing was driven yet"
    for number, passage in enumerate(passages[1:], start=1):
        true = true_camera(float(SHORT[4 * number - 4])).inv() * true_camera(
            float(SHORT[4 * number])
        )
        assert passage.by_wheels is not None
        by_wheels = passage.by_wheels.by(wheels.grip)
        error = np.linalg.norm((true.inv() * by_wheels.T_map_camera).translation)
        assert error < 0.06 * np.linalg.norm(true.translation)
        assert (np.linalg.eigvalsh(by_wheels.covariance) > 0).all()


def test_a_stretch_ends_where_the_scene_lets_go() -> None:
    _, passages = listened(set(range(1, 16)) - {6})
    stretches = [passage.stretch for passage in passages]
    assert stretches[0] == stretches[1] != stretches[2] == stretches[3]


def test_a_frame_that_contradicts_breaks_the_passage_and_only_that_one() -> None:
    wheels, by_scene, passages = Wheels(MotionSettings()), np.eye(6), []
    for number, frame in enumerate(short_drive()):
        wheels.heard(frame, None, broken=number == 6)
        if number % 4 == 0:
            passages.append(wheels.at_keyframe(by_scene))
    assert [passage.broken for passage in passages] == [False, False, True, False]
    assert [passage.by_scene is None for passage in passages] == [False, False, True, False]


SIZES = st.floats(-4.0, 300.0).map(lambda power: 10.0**power)


@example(866.0, 1e6, 0.0, False)
@example(99.0, 1e6, 0.0, False)
@given(SIZES, SIZES, st.floats(-np.pi, np.pi), st.booleans())
def test_a_wild_reading_leaves_numbers_that_can_be_calculated_with(
    size: float, variance: float, direction: float, stays: bool
) -> None:
    """One reading is anywhere, or all are from then on; a broken driver or message."""
    frames, settings = short_drive()[:4], MotionSettings()
    wheels, belief = Wheels(settings), Belief(true_camera(float(SHORT[0])), 1e-6 * np.eye(6))
    for number, frame in enumerate(frames):
        wild = number == 1 or (stays and number > 1)
        told, x, y = frame.odometry, size * np.cos(direction), size * np.sin(direction)
        if wild:
            there = PlanarPose(told.T_odom_base.x + x, told.T_odom_base.y + y, direction)
            told = replace(told, T_odom_base=there, covariance=variance * np.eye(3))
        heard = replace(frame, odometry=told)
        step = wheels.step(heard)
        if step is not None:
            moved = step.by(wheels.grip)
            belief = belief.moved(moved.T_map_camera, moved.covariance)
            belief = belief.held_to_floor(T_BASE_CAMERA, settings)
            assert np.isfinite(np.linalg.inv(belief.covariance)).all()
        elif number == 1:
            assert size > 0.5 * FARTHEST_STEP
        wheels.heard(heard, true_motion(number) if number else None)
    assert np.isfinite(wheels.grip.shares).all()


@pytest.mark.parametrize("size", [1e9, 1e300])
def test_wheels_that_leap_beyond_all_reason_are_as_good_as_none_for_that_step(size: float) -> None:
    frames = list(short_drive()[:7])
    told = frames[4].odometry
    there = replace(told.T_odom_base, x=size)
    frames[4] = replace(frames[4], odometry=replace(told, T_odom_base=there))
    estimates = follow(frames)
    assert [e.prior for e in estimates[3:]] == ["odometry", *2 * ["constant velocity"], "odometry"]
    assert place_errors(estimates, SHORT[:7]).max() < 0.02


def test_mute_wheels_tell_no_way() -> None:
    _, passages = listened(set(range(1, 16)), frozenset({6}))
    assert passages[1].by_wheels is not None
    assert passages[2].by_wheels is None
    assert passages[3].by_wheels is not None


def test_without_a_mount_the_wheels_say_nothing() -> None:
    wheels = Wheels(MotionSettings())
    for frame in short_drive()[:3]:
        wheels.heard(replace(frame, T_base_camera=None), None)
    assert wheels.step(replace(short_drive()[3], T_base_camera=None)) is None
    assert wheels.step(replace(short_drive()[3], T_base_camera=T_BASE_CAMERA)) is not None


def test_wheels_that_misled_are_worth_a_guess_until_they_are_right_again() -> None:
    frames, wheels, sure = short_drive(), Wheels(MotionSettings()), []
    stuck = frames[4].odometry
    for number, frame in enumerate(frames):
        told = replace(frame, odometry=stuck) if 4 < number < 10 else frame
        step = wheels.step(told)
        sure.append(step is not None and np.linalg.eigvalsh(step.noise)[-1] < 0.02**2)
        wheels.heard(told, true_motion(number) if number not in (0, 8) else None)
    # The first frame with stuck wheels can not be told; the others, the jump back, and what
    # follows until the scene agreed once, can.
    assert sure[1:6] == [True] * 5
    assert sure[6:12] == [False] * 6
    assert all(sure[12:])
