"""How much of what the wheels tell becomes motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import PlanarPose
from circumspect.mapping.wheel_grip import WheelGrip

shares = st.floats(0.8, 1.1)


def after_a_drive(way: float, turn: float, steps: int = 200, backwards: bool = False) -> WheelGrip:
    """Steps of 25 mm and 2° as the wheels tell them, found with 2 mm and 0.05° of noise."""
    rng, grip, sign = np.random.default_rng(0), WheelGrip(), -1 if backwards else 1
    for _ in range(steps):
        told = PlanarPose(sign * 0.025, 0.0, sign * np.radians(2))
        x, yaw = rng.normal([way * told.x, turn * told.yaw], [2e-3, np.radians(0.05)])
        grip = grip.taught(told, PlanarPose(float(x), 0.0, float(yaw)))
    return grip


def test_at_first_the_wheels_are_believed() -> None:
    assert WheelGrip().shares == (1.0, 1.0)


@given(shares, shares, st.booleans())
def test_slip_is_learnt(way: float, turn: float, backwards: bool) -> None:
    found = after_a_drive(way, turn, backwards=backwards).shares
    assert found == pytest.approx((way, turn), abs=0.015 + 0.12 * max(abs(1 - way), abs(1 - turn)))


def test_a_robot_that_stands_teaches_nothing() -> None:
    grip = WheelGrip()
    for _ in range(100):
        grip = grip.taught(PlanarPose(), PlanarPose(1e-3, 0.0, 1e-3))
    assert grip.shares == pytest.approx((1.0, 1.0), abs=0.4)
    assert grip.taught(PlanarPose(), PlanarPose()).shares == grip.shares


@pytest.mark.parametrize("found", [PlanarPose(), PlanarPose(0.3, 0, 0), PlanarPose(0.025, 0, 0.5)])
def test_jumps_and_wheels_that_spin_teach_nothing(found: PlanarPose) -> None:
    before = after_a_drive(0.95, 0.95)
    told = PlanarPose(0.06, 0.0, np.radians(2))
    assert before.taught(told, found) == before
