"""Angles within one turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.geometry import wrapped


@given(st.floats(-1e4, 1e4))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle: float) -> None:
    found = wrapped(angle)
    assert -np.pi <= found <= np.pi
    assert np.cos(found) == pytest.approx(np.cos(angle), abs=1e-8)
    assert np.sin(found) == pytest.approx(np.sin(angle), abs=1e-8)


def test_arrays_are_wrapped_as_their_elements() -> None:
    angles = np.array([-7.0, -np.pi, 0.0, 3.2, 100.0])
    np.testing.assert_array_equal(wrapped(angles), [wrapped(float(angle)) for angle in angles])
