"""Which of two attempts at a frame is believed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.attempt import Attempt
from circumspect.mapping.gate import Verdict
from circumspect.mapping.motion import Belief

NEAR = 0.001
"""Of the second attempt to the map, on the mean [m]."""


def at(x: float, yaw: float = 0.0) -> Belief:
    T = RigidTransform.from_exp_coords([0.0, 0.0, yaw, x, 0.0, 0.0])
    return Belief(T, np.eye(6))


STEADY, WHEELS = at(0.0), at(0.03)


def second(x: float, yaw: float = 0.0, verdict: Verdict | None = None) -> Attempt:
    found = SimpleNamespace(distance=NEAR)
    return Attempt(at(x, yaw), verdict or Verdict(), "constant velocity", found)


@pytest.mark.parametrize("x", [-0.02, 0.0, 0.02])
def test_a_fit_near_its_prediction_wins_where_it_comes_nearer_to_the_map(x: float) -> None:
    assert second(x).wins(1.1 * NEAR, NEAR, True, STEADY, WHEELS)
    assert not second(x).wins(0.9 * NEAR, NEAR, True, STEADY, WHEELS)


@pytest.mark.parametrize(("x", "yaw"), [(-0.08, 0.0), (0.08, 0.0), (0.0, 0.08)])
def test_one_that_slid_does_not_replace_one_that_is_in_order(x: float, yaw: float) -> None:
    """As at the edge of what is known of a bare side, 0.1 m back along it."""
    assert not second(x, yaw).wins(1.1 * NEAR, NEAR, True, STEADY, WHEELS)
    assert second(x, yaw).wins(1.1 * NEAR, NEAR, False, STEADY, WHEELS)


def test_one_that_slid_must_lie_as_frames_do_whatever_it_replaces() -> None:
    """As where a robot turns away from what it knows: its frame meets some other edge there."""
    assert not second(0.08).wins(np.inf, 0.9 * NEAR, False, STEADY, WHEELS)
    assert second(0.02).wins(np.inf, 0.9 * NEAR, False, STEADY, WHEELS)


def test_a_turn_does_not_vouch_for_a_shift() -> None:
    turned = at(0.0, yaw=0.105)
    assert not second(0.1).wins(np.inf, np.inf, True, STEADY, turned)
    assert second(0.0, yaw=0.1).wins(np.inf, np.inf, True, STEADY, turned)


def test_predictions_that_agree_leave_a_fit_its_millimetres() -> None:
    assert second(0.006).wins(1.1 * NEAR, NEAR, True, STEADY, at(0.002))


def test_one_that_the_gate_does_not_believe_never_wins() -> None:
    closed = second(0.0, verdict=Verdict("fits elsewhere as well", mute=True))
    assert not closed.wins(np.inf, np.inf, False, STEADY, WHEELS)
