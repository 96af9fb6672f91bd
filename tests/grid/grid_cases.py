"""Grids, points and beams that the tests of this folder share."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from circumspect.grid import AZIMUTH_AXIS, CylindricalGrid, Grid, OccupancyGrid, RectangularGrid
from circumspect.grid import numpy_twin as twin

NEAR = 1e-6
"""Points this close to a boundary, in cells, may fall on either side."""

seeds = st.integers(0, 2**32 - 1)


@st.composite
def grids(draw: st.DrawFn, most_cells: int = 40) -> Grid:
    """Any kind, shape, size, place and orientation."""
    cells = st.integers(1, most_cells)
    shape = (draw(st.integers(1, 90)), draw(cells), draw(cells))
    size = 10.0 ** draw(st.integers(-6, 6))
    centre = tuple(size * draw(st.floats(-3, 3)) for _ in range(3))
    angle = draw(st.one_of(st.just(0.0), st.floats(-7, 7)))
    if draw(st.booleans()):
        return CylindricalGrid(shape, size, size * draw(st.floats(0.3, 2)), centre, angle)
    return RectangularGrid(shape, size, centre, angle)


def size_of(grid: Grid) -> float:
    return grid.radius if isinstance(grid, CylindricalGrid) else grid.half_width


def points_about(grid: Grid, count: int, seed: int, spread: float = 0.7) -> NDArray[np.float64]:
    """Points in and around a grid."""
    rng = np.random.default_rng(seed)
    return grid.centre_xyz + size_of(grid) * spread * rng.normal(size=(count, 3))


def awkward_points(grid: Grid, count: int, seed: int) -> NDArray[np.float64]:
    """Points on axes, diagonals, boundaries and on each other."""
    rng = np.random.default_rng(seed)
    steps = rng.integers(-6, 7, (count, 3)) / 4
    return grid.centre_xyz + size_of(grid) * steps


def clear_of_boundaries(grid: Grid, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(…) whether points keep `NEAR` cells from every boundary, the axis included."""
    at = twin.places(grid, points_xyz)
    return (np.abs(at - np.rint(at)) > NEAR).all(axis=-1)


def assert_passed(grid: Grid, traced: OccupancyGrid, origins, ends) -> None:
    """Assert that passed cells are known, and cells that beams can not have touched are unknown."""
    origins = np.broadcast_to(origins, ends.shape)
    middles, lengths = twin.pieces(grid, origins, ends)
    sure = middles[clear_of_boundaries(grid, middles) & (lengths > 1e-9)]
    cells = twin.indices(grid, sure)
    cells = cells[cells[:, 0] >= 0]
    assert (traced.states[tuple(cells.T)] > 0).all(), "a cell on the way was missed"
    turns = _nearest_to_axis(grid, origins, ends)
    touched = _touched(grid, np.concatenate([middles.reshape(-1, 3), ends, turns]))
    assert not (traced.states > 0)[~touched].any(), "a cell off the way was marked"


def _nearest_to_axis(grid: Grid, origins, ends) -> NDArray[np.float64]:
    """Where beams come closest to the axis: tangents touch a shell there."""
    along, about = (ends - origins), (origins - np.array(grid.centre_xyz))
    squared = (along[:, :2] ** 2).sum(axis=1)
    t = -(along[:, :2] * about[:, :2]).sum(axis=1) / np.where(squared > 0, squared, 1.0)
    return origins + np.clip(t, 0, 1)[:, None] * along


def _touched(grid: Grid, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Cells within `NEAR` of points; all sectors for points on the axis."""
    at = twin.places(grid, points_xyz)
    shape = np.array(grid.shape)
    touched = np.zeros(grid.shape, bool)
    for offset in np.ndindex(3, 3, 3):
        moved = at + NEAR * (np.array(offset) - 1)
        inside = ((moved >= -2 * NEAR) & (moved <= shape + 2 * NEAR)).all(axis=-1)
        cells = np.clip(np.floor(moved[inside]), 0, shape - 1).astype(int)
        touched[tuple(cells.T)] = True
        if isinstance(grid, CylindricalGrid):
            wrapped = np.floor(moved[:, AZIMUTH_AXIS]).astype(int) % grid.shape[AZIMUTH_AXIS]
            cells[:, AZIMUTH_AXIS] = wrapped[inside]
            touched[tuple(cells.T)] = True
            on_axis = cells[at[inside, 0] < NEAR]
            touched[on_axis[:, 0], :, on_axis[:, 2]] = True
            # Azimuth is ill-defined close to the axis: there NEAR is in cells of the radius.
            close = cells[at[inside, 0] < 10 * NEAR * grid.shape[AZIMUTH_AXIS]]
            touched[close[:, 0], :, close[:, 2]] = True
    return touched


def turned(points_xyz: NDArray[np.float64], centre_xyz, alpha: float) -> NDArray[np.float64]:
    """Points turned counter-clockwise about the vertical through a centre."""
    x, y, z = (points_xyz - np.asarray(centre_xyz)).T
    cosine, sine = math.cos(alpha), math.sin(alpha)
    about = np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=1)
    return about + np.asarray(centre_xyz)
