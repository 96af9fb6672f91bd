from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.robot import DifferentialDrive, Velocity, arc

DRIVE = DifferentialDrive()
speeds = st.floats(-5, 5)


@given(forward=speeds, turn=speeds)
def test_wheel_speeds_and_velocity_are_inverse(forward: float, turn: float) -> None:
    velocity = DRIVE.velocity(*DRIVE.wheel_speeds(Velocity(forward, turn)))
    assert velocity.forward == pytest.approx(forward, abs=1e-12)
    assert velocity.turn == pytest.approx(turn, abs=1e-12)


@given(left=speeds, right=speeds, share=st.floats(0, 1))
def test_an_arc_driven_in_two_pieces_ends_at_the_same_place(
    left: float, right: float, share: float
) -> None:
    whole = DRIVE.motion(left, right)
    rest = 1 - share
    pieces = DRIVE.motion(share * left, share * right) @ DRIVE.motion(rest * left, rest * right)
    assert_same(pieces, whole)


@given(radius=st.floats(0.1, 10), turn=st.floats(-3, 3))
def test_an_arc_lies_on_its_circle(radius: float, turn: float) -> None:
    end = arc(radius * turn, turn)
    assert_same(end, PlanarPose(radius * np.sin(turn), radius * (1 - np.cos(turn)), turn))


def test_equal_wheels_go_straight_and_opposite_ones_turn_on_the_spot() -> None:
    assert_same(DRIVE.motion(2, 2), PlanarPose(2 * 0.0975, 0, 0))
    assert_same(DRIVE.motion(-1, 1), PlanarPose(0, 0, 2 * 0.0975 / 0.33))


def test_turning_left_the_right_wheel_is_the_faster_one() -> None:
    left, right = DRIVE.wheel_speeds(Velocity(0.1, 0.2))
    assert right > left


@given(forward=speeds, turn=speeds)
def test_clipping_keeps_the_arc(forward: float, turn: float) -> None:
    clipped = Velocity(forward, turn).clipped(1.2, 3.0)
    assert abs(clipped.forward) <= 1.2 + 1e-12
    assert abs(clipped.turn) <= 3.0 + 1e-12
    assert clipped.forward * turn == pytest.approx(clipped.turn * forward, abs=1e-9)


@pytest.mark.parametrize("lengths", [(0, 0.3), (0.1, -1), (np.nan, 0.3), (0.1, np.inf)])
def test_impossible_wheels_are_refused(lengths: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="positive"):
        DifferentialDrive(*lengths)


def test_a_velocity_must_be_finite() -> None:
    with pytest.raises(InputError, match="finite"):
        Velocity(np.nan, 0)


def assert_same(one: PlanarPose, other: PlanarPose) -> None:
    between = one.inverse() @ other
    np.testing.assert_allclose([between.x, between.y, between.yaw], 0, atol=1e-9)
