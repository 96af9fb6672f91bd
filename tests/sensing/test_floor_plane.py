from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.sensing import FloorPlane


def floor_points(plane: FloorPlane, seed: int, count: int = 1500) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.5, 2.5, (2, count))
    z = plane.slope_x * x + plane.slope_y * y + plane.offset + rng.normal(0, 0.002, count)
    return np.column_stack([x, y, z])


@settings(deadline=None)
@given(
    a=st.floats(-0.012, 0.012), b=st.floats(-0.012, 0.012), c=st.floats(-0.015, 0.015),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_finds_the_floor_despite_objects_on_it(a: float, b: float, c: float, seed: int) -> None:
    truth = FloorPlane(a, b, c)
    rng = np.random.default_rng(seed)
    feet = np.column_stack([rng.uniform(0.9, 1.1, (300, 2)), rng.uniform(0.0, 0.5, 300)])
    fitted = FloorPlane().refined(np.concatenate([floor_points(truth, seed), feet]))
    where = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [2, 2, 0]])
    np.testing.assert_allclose(fitted.heights(where), truth.heights(where), atol=0.0015)


def test_too_little_floor_keeps_the_assumed_plane() -> None:
    assert FloorPlane().refined(floor_points(FloorPlane(0.01), 0, count=50)) == FloorPlane()
    assert FloorPlane().refined(np.empty((0, 3))) == FloorPlane()


def test_a_ramp_is_not_taken_for_the_floor() -> None:
    assert FloorPlane().refined(floor_points(FloorPlane(0.2), 0)) == FloorPlane()


def test_heights_are_above_the_plane() -> None:
    plane = FloorPlane(0.1, -0.2, 0.3)
    assert plane.heights(np.array([[1.0, 1.0, 1.0]]))[0] == pytest.approx(1 - 0.1 + 0.2 - 0.3)
