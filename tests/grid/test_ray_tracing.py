"""Beams whose cells are known beforehand."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.grid import FREE, OCCUPIED, UNKNOWN, CylindricalGrid, RectangularGrid

GRID = CylindricalGrid((4, 8, 4))
SMALL = 0.05


def known(traced, state):
    return sorted(map(tuple, np.argwhere(traced.states == state).tolist()))


def test_a_beam_along_the_radius():
    traced = GRID.trace([2.0, 0.1, 0.1], [[0.55, 0.1, 0.1]])
    assert known(traced, OCCUPIED) == [(2, 0, 2)]
    assert known(traced, FREE) == [(3, 0, 2)]
    assert (traced.states == UNKNOWN).sum() == 4 * 8 * 4 - 2


def test_a_beam_through_the_axis_jumps_to_the_sector_behind():
    ray = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    traced = GRID.trace(-2 * ray + [0, 0, 0.1], [2 * ray + [0, 0, 0.1]])
    expected = [(i, j, 2) for i in range(4) for j in (0, 4)]
    assert known(traced, FREE) == expected
    assert known(traced, OCCUPIED) == []


def test_a_beam_just_beside_the_axis_sweeps_half_the_sectors_in_the_first_ring():
    traced = GRID.trace([-2.0, 1e-3, 0.1], [[2.0, 1e-3, 0.1]])
    expected = [(0, j, 2) for j in range(4)] + [(i, j, 2) for i in (1, 2, 3) for j in (0, 3)]
    assert known(traced, FREE) == sorted(expected)
    traced = GRID.trace([-2.0, -1e-3, 0.1], [[2.0, -1e-3, 0.1]])
    expected = [(0, j, 2) for j in range(4, 8)] + [(i, j, 2) for i in (1, 2, 3) for j in (4, 7)]
    assert known(traced, FREE) == sorted(expected)


def test_a_vertical_beam_passes_all_layers():
    traced = GRID.trace([0.6, 0.1, 5.0], [[0.6, 0.1, -5.0]])
    assert known(traced, FREE) == [(2, 0, k) for k in range(4)]
    traced = GRID.trace([0.6, 0.1, 5.0], [[0.6, 0.1, 0.1]])
    assert known(traced, FREE) == [(2, 0, 3)]
    assert known(traced, OCCUPIED) == [(2, 0, 2)]


def test_a_vertical_beam_on_the_axis_stays_in_the_first_ring():
    traced = GRID.trace([0.0, 0.0, 5.0], [[0.0, 0.0, -5.0]])
    (cells,) = {tuple(sorted(k for _, _, k in known(traced, FREE)))}
    assert cells == (0, 1, 2, 3)
    assert {i for i, _, _ in known(traced, FREE)} == {0}


def test_a_tangent_stays_outside_the_shell_it_touches():
    traced = GRID.trace([0.5 + 1e-9, -2.0, 0.1], [[0.5 + 1e-9, 2.0, 0.1]])
    assert {i for i, _, _ in known(traced, FREE)} == {2, 3}
    traced = GRID.trace([0.5 - 1e-6, -2.0, 0.1], [[0.5 - 1e-6, 2.0, 0.1]])
    assert {i for i, _, _ in known(traced, FREE)} == {1, 2, 3}


def test_a_beam_of_no_length_marks_its_cell():
    traced = GRID.trace([0.1, 0.1, 0.1], [[0.1, 0.1, 0.1]])
    assert (known(traced, FREE), known(traced, OCCUPIED)) == ([], [(0, 1, 2)])
    traced = GRID.trace([0.1, 0.1, 0.1], [[0.1, 0.1, 0.1]], returned=[False])
    assert (known(traced, FREE), known(traced, OCCUPIED)) == ([(0, 1, 2)], [])


def test_beams_from_inside_and_beams_that_miss():
    traced = GRID.trace([0.1, SMALL, 0.1], [[9.0, 9 * SMALL, 0.1]])
    assert known(traced, FREE) == [(i, 0, 2) for i in range(4)]
    for ends in ([[3.0, 2.0, 0.1]], [[-3.0, 0.1, 1.1]], [[1.5, 0.0, 0.0]]):
        origin = [3.0, -2.0, ends[0][2]]
        assert not GRID.trace(origin, ends).states.any()


def test_occupied_wins_over_free_over_unknown():
    ends = [[0.6, 0.1, 0.1], [-0.6, 0.1, 0.1]]  # the second beam passes where the first ended
    traced = GRID.trace([2.0, 0.1, 0.1], ends)
    assert traced.states[2, 0, 2] == OCCUPIED
    assert traced.states[3, 0, 2] == FREE
    assert traced.states[3, 4, 2] == UNKNOWN


def test_the_binary_grid_is_the_projection_of_the_traced_one():
    rng = np.random.default_rng(0)
    ends = rng.uniform(-0.9, 0.9, (300, 3))
    for grid in (CylindricalGrid(), RectangularGrid(yaw=0.2)):
        assert np.array_equal(grid.trace([3.0, 1.0, 1.0], ends).occupied, grid.hits(ends).occupied)


def test_a_beam_through_a_cube_takes_each_cell_once_in_order():
    cube = RectangularGrid((4, 4, 4))
    traced = cube.trace([-2.0, 0.1, 0.1], [[0.6, 0.1, 0.1]])
    assert known(traced, FREE) == [(0, 2, 2), (1, 2, 2), (2, 2, 2)]
    assert known(traced, OCCUPIED) == [(3, 2, 2)]
    traced = cube.trace([0.1, 2.0, 0.1], [[0.1, -0.1, 0.1]])
    assert known(traced, FREE) == [(2, 2, 2), (2, 3, 2)]


def test_clouds_are_accepted_as_ends():
    cloud = PointCloud(np.array([[0.5, 0.1, 0.1], [0.7, 0.2, 0.1]]))
    assert np.array_equal(
        GRID.trace([2.0, 0, 0], cloud).states, GRID.trace([2.0, 0, 0], cloud.points_xyz).states
    )
    assert np.array_equal(GRID.hits(cloud).states, GRID.hits(cloud.points_xyz).states)


def test_no_beams_leave_everything_unknown():
    assert not GRID.trace(np.zeros(3), np.zeros((0, 3))).states.any()
    assert not GRID.trace(np.zeros((0, 3)), np.zeros((0, 3))).states.any()
    assert not GRID.hits(np.zeros((0, 3))).states.any()


@pytest.mark.parametrize("grid", [GRID, RectangularGrid()])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e51])
def test_beams_that_are_not_finite_are_refused(grid, bad):
    sound, broken = np.zeros((4, 3)), np.zeros((4, 3))
    broken[2, 1] = bad
    for origins, ends in ((sound, broken), (broken, sound), (broken[2], sound)):
        with pytest.raises(GeometryError, match="NaN, infinite or beyond"):
            grid.trace(origins, ends)
    with pytest.raises(GeometryError, match="1 of 4 points are NaN"):
        grid.hits(broken)
    with pytest.raises(GeometryError, match="1 of 4 points are NaN"):
        grid.indices(broken.astype(np.float32) if abs(bad) != 1e51 else broken)


@pytest.mark.parametrize(
    ("origins", "ends", "returned", "message"),
    [
        (np.zeros((2, 3)), np.zeros((5, 3)), None, "2 origins for 5 ends"),
        (np.zeros(2), np.zeros((5, 3)), None, r"origins must have shape \(n, 3\), not \(1, 2\)"),
        (np.zeros(3), np.zeros((5, 4)), None, r"ends must have shape \(n, 3\), not \(5, 4\)"),
        (np.zeros(3), np.zeros((5, 3), complex), None, "ends must be real numbers"),
        (np.zeros(3), np.zeros((5, 3)), np.ones(4, bool), "returned must be bool of shape"),
        (np.zeros(3), np.zeros((5, 3)), np.ones(5), "returned must be bool of shape"),
    ],
)
def test_beams_of_wrong_shape_are_refused(origins, ends, returned, message):
    with pytest.raises(InputError, match=message):
        GRID.trace(origins, ends, returned)


@pytest.mark.parametrize(("threads", "message"), [(-1, "or more"), (1.5, "whole"), (None, "whole")])
def test_an_invalid_number_of_threads_is_refused(threads, message):
    with pytest.raises(InputError, match=message):
        GRID.hits(np.zeros((1, 3)), threads)
