from __future__ import annotations

import numpy as np
import pytest
from grid_cases import seeds
from hypothesis import given

from circumspect.errors import InputError
from circumspect.grid import FREE, OCCUPIED, CylindricalGrid, OccupancyGrid, RectangularGrid

GRID = CylindricalGrid((2, 3, 4))


def random(seed):
    return OccupancyGrid(GRID, np.random.default_rng(seed).integers(0, 3, GRID.shape, np.uint8))


@given(seeds, seeds, seeds)
def test_merging_is_a_maximum(a, b, c):
    first, second, third = random(a), random(b), random(c)
    merged = first.merged(second)
    assert np.array_equal(merged.states, second.merged(first).states)
    assert np.array_equal(merged.merged(second).states, merged.states)
    assert np.array_equal(merged.merged(third).states, first.merged(second.merged(third)).states)
    assert np.array_equal(merged.occupied, first.occupied | second.occupied)


def test_states_are_distinct_and_read_only():
    grid = random(0)
    assert np.array_equal(grid.occupied, grid.states == OCCUPIED)
    assert np.array_equal(grid.free, grid.states == FREE)
    with pytest.raises(ValueError, match="read-only"):
        grid.states[0] = 1


def test_merging_other_bounds_is_refused():
    with pytest.raises(InputError, match="same bounds"):
        random(0).merged(OccupancyGrid(CylindricalGrid((2, 3, 4), 2.0), random(1).states))
    with pytest.raises(InputError, match="same bounds"):
        random(0).merged(OccupancyGrid(RectangularGrid((2, 3, 4)), random(1).states))


@pytest.mark.parametrize(
    ("states", "message"),
    [
        (np.zeros((2, 3, 5), np.uint8), r"shape \(2, 3, 4\), not \(2, 3, 5\)"),
        (np.zeros((2, 3, 4)), "uint8, not float64"),
        (np.full((2, 3, 4), 3, np.uint8), "0, 1 or 2, not 3"),
    ],
)
def test_wrong_states_are_refused(states, message):
    with pytest.raises(InputError, match=message):
        OccupancyGrid(GRID, states)
