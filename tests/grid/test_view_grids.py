"""All grids of one object in one pass equal the grids filled one by one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from grid_cases import awkward_points, points_about, seeds
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.grid import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    CylindricalGrid,
    RectangularGrid,
    _native,
    hits_batch,
    hits_views,
    trace_views,
)

POINTS = np.random.default_rng(0).normal(size=(50, 3))
GRID = CylindricalGrid((6, 10, 7))
SHIFTS = np.array([0.0, 1e-16, 1e-9, 1e-7, 3e-7, 1e-6, 1.5e-6, 2e-6, 1e-5])
"""Of points from a border, in parts of an axis: rounding begins to matter among these."""


@st.composite
def views(
    draw: st.DrawFn, most_ratio: float = 1.3, most_rise: float = 0.2
) -> list[CylindricalGrid]:
    """Grids about one axis: of any shape, unit and place, with other offsets, sizes and heights."""
    cells = st.integers(1, 40)
    shape = (draw(st.integers(1, 90)), draw(cells), draw(cells))
    unit = 10.0 ** draw(st.integers(-6, 6))
    x, y, z = (unit * draw(st.floats(-3, 3)) for _ in range(3))
    flatness = draw(st.floats(0.3, 2))
    ratios = st.floats(1 / most_ratio, most_ratio)
    return [
        CylindricalGrid(
            shape,
            unit * draw(ratios),
            unit * flatness * draw(ratios),
            (x, y, z + unit * draw(st.floats(-most_rise, most_rise))),
            draw(st.one_of(st.just(0.0), st.floats(-7, 7))),
        )
        for _ in range(draw(st.integers(1, 5)))
    ]


def border_points(grids: list[CylindricalGrid], count: int, seed: int) -> NDArray[np.float64]:
    """Points on borders of cells, near them, and near the axis."""
    rng, found = np.random.default_rng(seed), []
    for grid in grids:
        rings, sectors, layers = grid.shape
        at = rng.uniform(0, 1, (3, count)) * np.array(grid.shape)[:, None]
        on_border = rng.random((3, count)) < 0.5
        at = np.where(on_border, np.rint(at), at)
        shifts = rng.choice(SHIFTS, (3, count)) * rng.choice([-1, 1], (3, count))
        r, turn, height = at / [[rings], [sectors], [layers]] + shifts
        r = np.where(rng.random(count) < 0.1, np.abs(shifts[0]), r) * grid.radius
        azimuth = grid.azimuth_offset + math.tau * turn
        z = grid.half_height * (2 * height - 1)
        about = np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], axis=1)
        found.append(about + grid.centre_xyz)
    return np.concatenate(found)


def one_by_one(grids: list[CylindricalGrid], points_xyz: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.stack([grid.hits(points_xyz).states for grid in grids])


@given(views(), seeds, st.integers(0, 400), st.sampled_from([np.float32, np.float64]))
def test_hits_equal_those_of_each_grid(grids, seed, count, dtype):
    points = points_about(grids[0], count, seed).astype(dtype)
    assert np.array_equal(hits_views(grids, points), one_by_one(grids, points))


@given(views(), seeds, st.sampled_from([np.float32, np.float64]))
def test_hits_of_points_on_borders_equal_those_of_each_grid(grids, seed, dtype):
    points = border_points(grids, 100, seed).astype(dtype)
    states = hits_views(grids, points)
    assert np.array_equal(states, one_by_one(grids, points))
    for grid in grids:
        awkward = awkward_points(grid, 100, seed)
        assert np.array_equal(hits_views(grids, awkward), one_by_one(grids, awkward))


@given(views(), seeds)
def test_each_point_is_in_the_cell_of_each_grid(grids, seed):
    """One point at a time: in the states of many, one could stand for another."""
    for point in border_points(grids, 8, seed):
        assert np.array_equal(hits_views(grids, point[None]), one_by_one(grids, point[None]))


@given(
    st.one_of(views(most_ratio=1e8), views(most_ratio=1e8, most_rise=1e4), views(1.3, 1e4)), seeds
)
def test_hits_equal_those_of_grids_that_differ_much_in_size_and_height(grids, seed):
    for grid in grids:
        points = np.concatenate([points_about(grid, 50, seed), border_points([grid], 50, seed)])
        assert np.array_equal(hits_views(grids, points), one_by_one(grids, points))


def test_hits_equal_those_of_grids_of_very_many_cells():
    grids = [CylindricalGrid((300, 300, 200), azimuth_offset=turn) for turn in (0.0, 0.01)]
    points = points_about(grids[0], 20_000, 0, 0.4)
    assert np.array_equal(hits_views(grids, points), one_by_one(grids, points))


def test_far_points_and_tiny_grids_do_not_overflow():
    far = np.array([[1e49, 0, 0], [0, -1e49, 1e49], [1e49, 1e49, -1e49], [0, 0, 1e49]])
    for size in (2e-50, 1e-40, 1.0, 1e40, 1e50):
        grids = [CylindricalGrid(radius=r * size, half_height=size) for r in (1.0, 0.9)]
        assert np.array_equal(hits_views(grids, far), one_by_one(grids, far))
        near = 0.3 * size * POINTS
        assert np.array_equal(hits_views(grids, near), one_by_one(grids, near))


@given(views(), seeds, st.floats(-7, 7))
def test_yaw_turns_the_points_about_the_axis(grids, seed, yaw):
    points = np.concatenate([points_about(grids[0], 50, seed), border_points(grids, 20, seed)])
    x, y, z = (points - (*grids[0].centre_xyz[:2], 0.0)).T
    cosine, sine = math.cos(yaw), math.sin(yaw)
    turned = np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=1)
    about = [grid.recentred((0.0, 0.0, grid.centre_xyz[2])) for grid in grids]
    assert np.array_equal(hits_views(grids, points, yaw), one_by_one(about, turned))


@given(views(), seeds, st.floats(-7, 7))
def test_yaw_of_points_equals_the_opposite_turn_of_grids_but_for_rounding(grids, seed, yaw):
    points = points_about(grids[0], 300, seed)
    turned = [replace(grid, azimuth_offset=grid.azimuth_offset - yaw) for grid in grids]
    differing = hits_views(grids, points, yaw) != hits_views(turned, points)
    assert differing.sum() <= 4


@given(views(), seeds, st.sampled_from([0.2, 1.0, 5.0]), st.booleans(), st.booleans())
def test_traced_cells_equal_those_of_each_grid(grids, seed, spread, one_origin, single):
    count = 1 + seed % 300
    origins = points_about(grids[0], 1 if one_origin else count, seed, spread)
    ends = points_about(grids[0], count, seed + 1, spread)
    if single:
        origins, ends = origins.astype(np.float32), ends.astype(np.float32)
    assert np.array_equal(trace_views(grids, origins, ends), traced(grids, origins, ends))


@given(views(), seeds)
def test_awkward_beams_are_traced_as_in_each_grid(grids, seed):
    origins = awkward_points(grids[0], 60, seed)
    ends = border_points(grids, 60, seed)[:60]
    assert np.array_equal(trace_views(grids, origins, ends), traced(grids, origins, ends))


def traced(grids, origins, ends) -> NDArray[np.uint8]:
    none = np.zeros(len(ends), bool)
    return np.stack([grid.trace(origins, ends, none).states for grid in grids])


@pytest.mark.parametrize("count", [1, 2, 3, 8])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_number_of_threads_does_not_change_results(count, dtype):
    grids = [CylindricalGrid(azimuth_offset=0.1 * n, radius=1 + 0.01 * n) for n in range(count)]
    points = points_about(grids[0], 40_000, 0).astype(dtype)
    origins, ends = points[:9_000], points_about(grids[0], 9_000, 1, 0.5).astype(dtype)
    hits, passed = hits_views(grids, points, threads=1), trace_views(grids, origins, ends, 1)
    assert np.array_equal(hits, one_by_one(grids, points))
    assert np.array_equal(passed, traced(grids, origins, ends))
    for threads in (0, 2, 5, 64):
        assert np.array_equal(hits_views(grids, points, threads=threads), hits)
        assert np.array_equal(trace_views(grids, origins, ends, threads), passed)


def test_states_are_those_of_grids():
    hits, passed = hits_views([GRID], POINTS), trace_views([GRID], (0, 0, 0), POINTS)
    assert hits.dtype == passed.dtype == np.uint8
    assert hits.shape == passed.shape == (1, 6, 10, 7)
    assert set(np.unique(hits)) == {UNKNOWN, OCCUPIED}
    assert set(np.unique(passed)) == {UNKNOWN, FREE}


def test_without_points_or_beams_all_is_unknown():
    none = np.empty((0, 3))
    assert not hits_views([GRID, GRID], none).any()
    assert not trace_views([GRID, GRID], none, none).any()
    assert not trace_views([GRID, GRID], np.zeros(3), none).any()


@pytest.mark.parametrize(
    ("grids", "says"),
    [
        ([], "no grids"),
        ([GRID, RectangularGrid()], "views are cylindrical grids, not RectangularGrid"),
        ([GRID, CylindricalGrid((6, 10, 8))], r"one shape, not \[\(6, 10, 7\), \(6, 10, 8\)\]"),
        ([GRID, GRID.recentred((0, 1e-9, 0))], "one axis, not axes at"),
    ],
)
def test_grids_that_are_not_views_of_one_object_are_refused(grids, says):
    with pytest.raises(InputError, match=says):
        hits_views(grids, POINTS)
    with pytest.raises(InputError, match=says):
        trace_views(grids, POINTS, POINTS)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("threads", [1, 3])
def test_points_that_are_not_finite_are_counted_and_refused(dtype, value, threads):
    broken = points_about(GRID, 30_000, 0).astype(dtype)
    good = broken.copy()
    broken[[7, 29_000], [2, 0]] = value
    with pytest.raises(GeometryError, match="2 of 30000 points are NaN"):
        hits_views([GRID] * 3, broken, threads=threads)
    with pytest.raises(GeometryError, match="2 of 30000 beams are NaN"):
        trace_views([GRID] * 3, good, broken, threads)
    with pytest.raises(GeometryError, match="1 of 30000 beams are NaN"):
        trace_views([GRID] * 3, broken[7], good, threads)


def test_points_beyond_the_arithmetic_are_refused():
    with pytest.raises(GeometryError, match="beyond 1e50"):
        hits_views([GRID], [[1e51, 0, 0]])


def test_wrong_arguments_are_refused():
    with pytest.raises(InputError, match=r"shape \(n, 3\)"):
        hits_views([GRID], POINTS[:, :2])
    with pytest.raises(InputError, match="yaw must be finite"):
        hits_views([GRID], POINTS, np.nan)
    with pytest.raises(InputError, match="threads"):
        hits_views([GRID], POINTS, threads=-1)
    with pytest.raises(InputError, match="2 origins for 50 ends"):
        trace_views([GRID], POINTS[:2], POINTS)
    with pytest.raises(InputError, match="threads"):
        trace_views([GRID], POINTS, POINTS, -1)


def test_the_kernels_refuse_outputs_of_wrong_size():
    kernels = [GRID.kernels(), GRID.kernels()]
    states = np.zeros((2, *GRID.shape), np.uint8)

    def calls(grids, out):
        yield lambda: _native.hits_coaxial(grids, POINTS, 0.0, out, 1, 1)
        yield lambda: _native.passed_coaxial(grids, POINTS, POINTS, out, 1, 1)

    others = [
        [],
        kernels[:1],
        [kernels[0], CylindricalGrid((6, 10, 8)).kernels()],
        [kernels[0], GRID.recentred((1, 0, 0)).kernels()],
        [kernels[0], None],
    ]
    for grids in others:
        for call in calls(grids, states):
            with pytest.raises((ValueError, TypeError)):
                call()
    for out in (np.zeros((2, 7, 10, 6), np.uint8).T, np.zeros(states.shape), states[:, :, :, ::2]):
        for call in calls(kernels, out):
            with pytest.raises((ValueError, TypeError)):
                call()
    with pytest.raises(ValueError, match="yaw"):
        _native.hits_coaxial(kernels, POINTS, np.nan, states, 1, 1)
    with pytest.raises(ValueError, match="one origin"):
        _native.passed_coaxial(kernels, POINTS[:2], POINTS, states, 1, 1)
    assert not states.any()


def test_a_batch_of_one_cloud_is_the_same():
    grids = [CylindricalGrid(azimuth_offset=0.1 * n) for n in range(4)]
    batch = hits_batch(grids, [POINTS] * 4)
    assert np.array_equal(batch, hits_views(grids, POINTS) == OCCUPIED)
