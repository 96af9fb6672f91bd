from __future__ import annotations

import math

import numpy as np
import pytest
from grid_cases import clear_of_boundaries, points_about, seeds, turned
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud
from circumspect.grid import AZIMUTH_AXIS, CylindricalGrid, RectangularGrid

kinds = st.sampled_from([CylindricalGrid, RectangularGrid])


@given(seeds, st.integers(1, 48), st.integers(-100, 100))
def test_a_turn_by_whole_cells_rolls_the_grid_by_as_many(seed, sectors, k):
    grid = CylindricalGrid((7, sectors, 5), 1.3, 0.9, (0.2, -0.4, 3.0), azimuth_offset=0.3)
    points = points_about(grid, 300, seed)
    points = points[clear_of_boundaries(grid, points)]
    moved = turned(points, grid.centre_xyz, k * math.tau / sectors)
    expected = np.roll(grid.hits(points).states, k, axis=AZIMUTH_AXIS)
    assert np.array_equal(grid.hits(moved).states, expected)


@given(seeds, st.sampled_from([4, 8, 12, 32, 64]))
def test_a_quarter_turn_is_exact_even_on_boundaries(seed, sectors):
    grid = CylindricalGrid((8, sectors, 6))
    points = np.random.default_rng(seed).integers(-8, 9, (200, 3)) / 8
    points = points[(points[:, :2] != 0).any(axis=1)]  # the axis has no azimuth
    quarter = np.stack([-points[:, 1], points[:, 0], points[:, 2]], axis=1)
    expected = np.roll(grid.hits(points).states, sectors // 4, axis=AZIMUTH_AXIS)
    assert np.array_equal(grid.hits(quarter).states, expected)


@given(seeds, st.integers(1, 40), st.integers(-50, 50))
def test_a_turn_of_the_grid_undoes_a_turn_of_the_points(seed, sectors, k):
    grid = CylindricalGrid((5, sectors, 6), 1.0, 1.0, azimuth_offset=0.1)
    points = points_about(grid, 200, seed)
    points = points[clear_of_boundaries(grid, points)]
    expected = np.roll(grid.hits(points).states, -k, axis=AZIMUTH_AXIS)
    assert np.array_equal(grid.rotated(k).hits(points).states, expected)


@given(seeds, st.sampled_from([4, 32]), st.floats(-7, 7))
def test_traced_beams_turn_with_the_grid(seed, sectors, offset):
    grid = CylindricalGrid((9, sectors, 8), azimuth_offset=offset)
    origins, ends = points_about(grid, 40, seed), points_about(grid, 40, seed + 1)
    rolled = np.roll(grid.trace(origins, ends).states, 3, axis=AZIMUTH_AXIS)
    alpha = 3 * math.tau / sectors
    traced = grid.trace(turned(origins, (0, 0, 0), alpha), turned(ends, (0, 0, 0), alpha))
    assert np.array_equal(traced.states, rolled)


@given(seeds, kinds, st.integers(-6, 6), st.integers(1, 400))
def test_fit_holds_all_points_and_is_tight(seed, kind, exponent, count):
    rng = np.random.default_rng(seed)
    stretch = 10.0 ** rng.uniform(-2, 0, 3)
    points = 10.0**exponent * (stretch * rng.normal(size=(count + 1, 3)) + 5 * rng.normal(size=3))
    grid = kind.fit(PointCloud(points))
    cells = grid.indices(points)
    assert (cells >= 0).all()
    # Tight: the farthest point falls into a last cell, of radius or of either side.
    outermost = cells.max(axis=0) == 31
    lowest = cells.min(axis=0) == 0
    axes = [0, 2] if kind is CylindricalGrid else [0, 1, 2]
    assert outermost[axes].any() or lowest[2 if kind is CylindricalGrid else axes].any()


@given(seeds, kinds, st.floats(-6, 6), st.floats(-100, 100))
def test_fit_ignores_scale_and_place(seed, kind, exponent, shift):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, 3)) * [1.0, 0.6, 1.4]
    moved = 10.0**exponent * (points + np.array([shift, -2 * shift, 0.5 * shift]))
    first, second = kind.fit(PointCloud(points)), kind.fit(PointCloud(moved))
    clear = clear_of_boundaries(first, points)
    assert np.array_equal(first.indices(points)[clear], second.indices(moved)[clear])


def test_fit_puts_the_axis_through_the_area_weighted_centre():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 2]])
    grid = CylindricalGrid.fit(PointCloud(points, areas=np.array([2.0, 1.0, 1.0])))
    assert grid.centre_xyz == pytest.approx((0.5, 0.0, 0.5))
    assert grid.radius == grid.half_height == pytest.approx(1.5)
    flat = CylindricalGrid.fit(PointCloud(points), half_height_per_radius=4.0)
    assert flat.half_height == pytest.approx(4 * flat.radius)


def test_cells_count_from_the_axis_from_plus_x_and_from_below():
    grid = CylindricalGrid((4, 8, 2), radius=2.0, half_height=1.0)
    points = [[0.1, 0.01, -1.0], [1.9, 0.1, 0.5], [-0.6, 0.61, 0.5], [0, -1.2, -0.1], [0, 0, 1.1]]
    expected = [[0, 0, 0], [3, 0, 1], [1, 2, 1], [2, 6, 0], [-1, -1, -1]]
    assert grid.indices(np.array(points)).tolist() == expected


def test_the_outer_boundary_belongs_to_the_last_cell():
    grid = CylindricalGrid((4, 8, 6))
    assert grid.indices([[1.0, 0.0, 1.0], [0.0, -1.0, -1.0]]).tolist() == [[3, 0, 5], [3, 6, 0]]
    above = np.nextafter(1.0, 2.0)
    assert (grid.indices([[above, 0.0, 0.0], [0.0, 0.0, above]]) == -1).all()
    cube = RectangularGrid((4, 8, 6))
    assert cube.indices([[1.0, 1.0, 1.0], [-1, -1, -1]]).tolist() == [[3, 7, 5], [0, 0, 0]]
    assert (cube.indices([[above, 0.0, 0.0], [0.0, -above, 0.0]]) == -1).all()


def test_offsets_are_kept_within_a_turn():
    assert CylindricalGrid(azimuth_offset=-1e-20).azimuth_offset == 0.0
    assert CylindricalGrid(azimuth_offset=math.tau).azimuth_offset == 0.0
    assert CylindricalGrid(azimuth_offset=-math.pi / 2).azimuth_offset == pytest.approx(4.712389)
    assert CylindricalGrid().rotated(8).azimuth_offset == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("kind", [CylindricalGrid, RectangularGrid])
def test_a_grid_translates_with_its_centre(kind):
    grid, points = kind(centre_xyz=(1, 2, 3)), np.random.default_rng(0).normal(size=(50, 3))
    at_origin = grid.recentred()
    assert at_origin.centre_xyz == (0.0, 0.0, 0.0)
    points = points[clear_of_boundaries(at_origin, points)]
    moved = points + np.array([1, 2, 3])
    assert np.array_equal(grid.indices(moved), at_origin.indices(points))


@pytest.mark.parametrize("kind", [CylindricalGrid, RectangularGrid])
@pytest.mark.parametrize(
    "points", [np.ones((1, 3)), np.full((9, 3), 1e12), np.full((7, 3), 0.1), np.zeros((5, 3))]
)
def test_points_in_one_place_are_no_object(kind, points):
    with pytest.raises(GeometryError, match="in one place"):
        kind.fit(PointCloud(points))


@pytest.mark.parametrize("kind", [CylindricalGrid, RectangularGrid])
def test_points_beyond_arithmetic_are_refused(kind):
    with pytest.raises(GeometryError, match="unit"):
        kind.fit(PointCloud(np.array([[0.0, 0, 0], [1e60, 0, 0]])))
    for scale in (1e-30, 1e-12, 1e12, 1e30):
        points = scale * np.random.default_rng(0).normal(size=(30, 3))
        assert (kind.fit(PointCloud(points)).indices(points) >= 0).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shape": (0, 4, 4)}, "from 1 to 4096"),
        ({"shape": (4, 4)}, "three whole numbers"),
        ({"shape": (4, 4, 2.5)}, "three whole numbers"),
        ({"shape": 7}, "three whole numbers"),
        ({"shape": (4096, 4096, 4096)}, "take fewer"),
        ({"radius": 0.0}, "radius must lie between"),
        ({"radius": math.nan}, "radius must be finite"),
        ({"radius": "wide"}, "radius must be a number"),
        ({"half_height": -1.0}, "half_height must lie"),
        ({"centre_xyz": (0.0, 1.0)}, "centre is three numbers"),
        ({"centre_xyz": (0.0, math.inf, 1.0)}, "centre is three numbers"),
        ({"centre_xyz": ("a", "b", "c")}, "centre is three numbers"),
        ({"azimuth_offset": math.inf}, "azimuth_offset must be finite"),
    ],
)
def test_invalid_bounds_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        CylindricalGrid(**arguments)


def test_rectangular_grids_refuse_invalid_bounds():
    with pytest.raises(InputError, match="half_width"):
        RectangularGrid(half_width=-2.0)
    with pytest.raises(InputError, match="yaw"):
        RectangularGrid(yaw=math.nan)
    with pytest.raises(InputError, match="half_height_per_radius"):
        CylindricalGrid.fit(PointCloud(np.eye(3)), half_height_per_radius=0.0)


def test_a_cube_turned_by_quarters_holds_the_same_points():
    points = np.random.default_rng(1).normal(size=(100, 3)) * 0.5
    cube = RectangularGrid()
    turned_cells = cube.rotated(1).indices(points)
    expected = np.rot90(cube.hits(points).states, -1, axes=(0, 1))
    states = np.zeros(cube.shape, np.uint8)
    inside = turned_cells[turned_cells[:, 0] >= 0]
    states[tuple(inside.T)] = 2
    assert np.array_equal(states, expected)
