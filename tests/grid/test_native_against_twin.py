"""Native kernels and their NumPy twins agree cell for cell."""

from __future__ import annotations

import sys
import threading

import numpy as np
import pytest
from grid_cases import (
    assert_passed,
    awkward_points,
    clear_of_boundaries,
    grids,
    points_about,
    seeds,
    size_of,
)
from hypothesis import given
from hypothesis import strategies as st

from circumspect.grid import CylindricalGrid, RectangularGrid, _native, hits_batch
from circumspect.grid import numpy_twin as twin


@given(grids(), seeds, st.integers(0, 400))
def test_indices(grid, seed, count):
    points = points_about(grid, count, seed)
    clear = clear_of_boundaries(grid, points)
    assert np.array_equal(grid.indices(points)[clear], twin.indices(grid, points)[clear])


@given(grids(), seeds, st.integers(0, 400))
def test_hits(grid, seed, count):
    points = points_about(grid, count, seed)
    points = points[clear_of_boundaries(grid, points)]
    assert np.array_equal(grid.hits(points).states, twin.hits(grid, points).states)


@given(grids(), seeds)
def test_single_precision_gives_the_same_cells(grid, seed):
    points = points_about(grid, 300, seed).astype(np.float32)
    assert np.array_equal(grid.indices(points), grid.indices(points.astype(np.float64)))


@given(grids(), seeds)
def test_points_on_boundaries_fall_beside_them(grid, seed):
    points = awkward_points(grid, 200, seed)
    cells, at = grid.indices(points), twin.places(grid, points)
    inside = cells[:, 0] >= 0
    gap = np.abs(at[inside] - (cells[inside] + 0.5))
    if isinstance(grid, CylindricalGrid):
        gap[:, 1] = np.minimum(gap[:, 1], grid.shape[1] - gap[:, 1])
        gap[at[inside, 0] < 1e-6] = 0
    assert (gap <= 0.5 + 1e-6).all()


@given(st.booleans(), st.integers(1, 40), st.floats(1e-6, 1e6), seeds)
def test_points_on_the_middle_plane_are_in_the_cell_above(cylinder, half, size, seed):
    """Whatever the size: objects have many points on their planes of symmetry."""
    cells = 2 * half
    points = points_about(CylindricalGrid((1, 1, 1), size, size), 20, seed, 0.1)
    flat = points * (1, 1, 0)
    if cylinder:
        grid = CylindricalGrid((4, 8, cells), size, size)
    else:
        grid = RectangularGrid((cells, cells, cells), size)
        assert (grid.indices(points * (0, 1, 1))[:, 0] == half).all()
        assert (grid.indices(points * (1, 0, 1))[:, 1] == half).all()
    assert (grid.indices(flat)[:, 2] == half).all()
    assert (twin.indices(grid, flat)[:, 2] == half).all()
    traced = grid.trace(flat[0], flat)
    known = np.argwhere(traced.free | traced.occupied)
    assert (known[:, 2] == half).all()


@given(grids(), seeds, st.sampled_from([0.2, 1.0, 5.0]), st.booleans())
def test_trace(grid, seed, spread, one_origin):
    origins = points_about(grid, 1 if one_origin else 40, seed, spread)
    ends = points_about(grid, 40, seed + 1, spread)
    returned = np.random.default_rng(seed).random(40) < 0.5
    native = grid.trace(origins, ends, returned)
    assert np.array_equal(native.states, twin.trace(grid, origins, ends, returned).states)


@given(grids(), seeds, st.sampled_from(["any", "level", "vertical", "still", "inward"]))
def test_trace_of_awkward_beams(grid, seed, kind):
    origins, ends = awkward_points(grid, 30, seed), awkward_points(grid, 30, seed + 1)
    if kind == "level":
        ends[:, 2] = origins[:, 2]
    elif kind == "vertical":
        ends[:, :2] = origins[:, :2]
    elif kind == "still":
        ends = origins.copy()
    elif kind == "inward":
        ends[:, :2] = 2 * np.array(grid.centre_xyz[:2]) - origins[:, :2]
    assert_passed(grid, grid.trace(origins, ends), origins, ends)


@given(seeds, st.sampled_from([1e-3, 1e-7, 1e-12]))
def test_trace_of_beams_that_graze_the_axis_and_shells(seed, miss):
    rng = np.random.default_rng(seed)
    grid = CylindricalGrid((16, 24, 8), azimuth_offset=0.2)
    azimuth, height = rng.uniform(0, 7, 30), rng.uniform(-1, 1, (2, 30))
    aside = rng.choice([0.0, 0.25, 0.5, 1.0], 30) + miss * rng.choice([-1, 0, 1], 30)
    along = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) * aside[:, None]
    origins = np.concatenate([across - 2 * along, height[0][:, None]], axis=1)
    ends = np.concatenate([across + 2 * along, height[1][:, None]], axis=1)
    assert_passed(grid, grid.trace(origins, ends), origins, ends)


@pytest.mark.parametrize("distance", [1e3, 1e6])
def test_trace_from_far_away(distance):
    rng = np.random.default_rng(3)
    for grid in (CylindricalGrid((8, 12, 8)), RectangularGrid((8, 12, 8), yaw=0.3)):
        origins = distance * rng.normal(size=(50, 3))
        ends = rng.uniform(-1, 1, (50, 3))
        assert_passed(grid, grid.trace(origins, ends), origins, ends)
        assert_passed(grid, grid.trace(ends, origins), ends, origins)


@given(st.lists(seeds, min_size=1, max_size=6), st.integers(1, 3), st.booleans())
def test_batches(some_seeds, threads, single):
    clouds = [np.random.default_rng(s).normal(size=(s % 500, 3)) * 0.5 for s in some_seeds]
    if single:
        clouds = [cloud.astype(np.float32) for cloud in clouds]
    sizes = [1.0 + (s % 7) / 3 for s in some_seeds]
    for make in (
        lambda size: CylindricalGrid((6, 10, 7), size, size, azimuth_offset=0.2),
        lambda size: RectangularGrid((6, 10, 7), size, yaw=0.2),
    ):
        bounds = [make(size) for size in sizes]
        clear = [
            cloud[clear_of_boundaries(grid, cloud)]
            for grid, cloud in zip(bounds, clouds, strict=True)
        ]
        native = hits_batch(bounds, clear, threads)
        assert native.dtype == np.uint8
        assert np.array_equal(native, twin.hits_batch(bounds, clear))


@pytest.mark.parametrize("grid", [CylindricalGrid((70, 32, 32)), RectangularGrid(yaw=0.4)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_number_of_threads_does_not_change_results(grid, dtype):
    points = points_about(grid, 40_000, 0).astype(dtype)
    ends = points_about(grid, 9_000, 1, 0.5).astype(dtype)
    origins = points_about(grid, 9_000, 2, 2.0).astype(dtype)
    for threads in (0, 2, 5):
        assert np.array_equal(grid.indices(points, threads), grid.indices(points))
        assert np.array_equal(grid.hits(points, threads).states, grid.hits(points).states)
        several = grid.trace(origins, ends, threads=threads).states
        assert np.array_equal(several, grid.trace(origins, ends).states)


def test_other_layouts_give_the_same_cells():
    grid = CylindricalGrid()
    points = points_about(grid, 500, 0)
    expected = grid.indices(points)
    assert np.array_equal(grid.indices(np.asfortranarray(points)), expected)
    assert np.array_equal(grid.indices(np.repeat(points, 2, axis=0)[::2]), expected)
    assert np.array_equal(grid.indices(points.astype(">f8")), expected)
    unaligned = np.frombuffer(b"x" + points.tobytes(), np.uint8)[1:].view(np.float64)
    assert np.array_equal(grid.indices(unaligned.reshape(-1, 3)), expected)
    read_only = points.copy()
    read_only.flags.writeable = False
    assert np.array_equal(grid.indices(read_only), expected)
    assert grid.indices([[0, 0, 0]]).tolist() == grid.indices(np.zeros((1, 3))).tolist()


def test_far_points_do_not_overflow():
    for grid in (CylindricalGrid(radius=1e-40, half_height=1e-40), RectangularGrid()):
        far = np.array([[1e49, 0, 0], [0, -1e49, 1e49], [1e49, 1e49, -1e49]])
        assert (grid.indices(far) == -1).all()
        assert not grid.trace(far, far[::-1] + 1e48).occupied.any()
        assert grid.trace(far, np.zeros((3, 3))).occupied.sum() == 1
    assert size_of(RectangularGrid()) == 1.0


def test_kernels_release_the_interpreter_lock():
    clouds = [np.random.default_rng(0).normal(size=(500_000, 3))] * 100
    grid, started, finished = CylindricalGrid(), threading.Event(), []

    def work() -> None:
        started.set()
        hits_batch([grid] * len(clouds), clouds, threads=1)
        finished.append(True)

    interval = sys.getswitchinterval()
    sys.setswitchinterval(60.0)  # a thread only gives way where it releases the lock itself
    try:
        thread = threading.Thread(target=work)
        thread.start()
        started.wait()
        assert not finished
        thread.join()
    finally:
        sys.setswitchinterval(interval)


def other_layouts(shape: tuple[int, ...], dtype: type) -> list[np.ndarray]:
    """Outputs of the right size whose layout a kernel could only fill through a copy."""
    return [
        np.zeros(shape, dtype, order="F"),
        np.zeros((*shape[:-1], 2 * shape[-1]), dtype)[..., ::2],
        np.zeros(shape, np.float64),
    ]


@pytest.mark.parametrize("which", range(3))
@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("grid", [CylindricalGrid((3, 4, 5), 1.0), RectangularGrid((3, 4, 5), 1.0)])
def test_outputs_of_another_layout_are_refused(grid, precision, which):
    points, kernels = np.zeros((2, 3), precision), grid.kernels()
    states = other_layouts(grid.shape, np.uint8)[which]
    with pytest.raises(TypeError, match="incompatible function arguments"):
        kernels.hits(points, states, 1, 1)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        kernels.passed(points, points, states, 1, 1)
    with pytest.raises(TypeError, match="incompatible function arguments"):
        kernels.indices(points, other_layouts((2, 3), np.int32)[which], 1)
    batch = other_layouts((2, *grid.shape), np.uint8)[which]
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _native.hits_batch([kernels, kernels], [points, points], batch, 1, 1)
