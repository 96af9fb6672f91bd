"""Every native kernel again in NumPy, written to be obviously right: the oracle of the tests.

Nothing is shared with the C++ code, and ray tracing works by another method: all parameters at
which a beam can meet any boundary are sorted, and the cell between two of them is that of the
point half-way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.grid.cylindrical_grid import CylindricalGrid
from circumspect.grid.grid import FREE, OCCUPIED, Grid, OccupancyGrid
from circumspect.grid.rectangular_grid import RectangularGrid

SHORTEST = 1e-12
"""Pieces of a beam below this share of its length are rounding, not cells."""


def places(grid: Grid, points_xyz: ArrayLike) -> NDArray[np.float64]:
    """Where points lie, in cells: whole numbers are boundaries.

    Args:
        grid: Cylindrical or rectangular.
        points_xyz: (…, 3) [m].

    Returns:
        (…, 3) along the grid's axes; azimuth in 0 … its number of cells.
    """
    points = np.asarray(points_xyz, dtype=np.float64) - np.asarray(grid.centre_xyz)
    x, y, z = np.moveaxis(points, -1, 0)
    if isinstance(grid, CylindricalGrid):
        rings, sectors, layers = grid.shape
        radius = np.sqrt(x**2 + y**2) / grid.radius * rings
        azimuth = (np.arctan2(y, x) - grid.azimuth_offset) % math.tau / math.tau * sectors
        height = (z + grid.half_height) / (2 * grid.half_height) * layers
        return np.stack([radius, azimuth, height], axis=-1)
    local = np.stack(_turned(_rectangular(grid), x, y, z), axis=-1)
    half_width = _rectangular(grid).half_width
    return (local + half_width) / (2 * half_width) * np.array(grid.shape)


def indices(grid: Grid, points_xyz: ArrayLike) -> NDArray[np.int32]:
    """Twin of `Grid.indices`."""
    at = places(grid, points_xyz)
    shape = np.array(grid.shape)
    inside = ((at >= 0) & (at <= shape)).all(axis=-1, keepdims=True)
    cells = np.minimum(np.floor(np.where(inside, at, 0)), shape - 1).astype(np.int32)
    return np.where(inside, cells, np.int32(-1))


def hits(grid: Grid, points_xyz: ArrayLike) -> OccupancyGrid:
    """Twin of `Grid.hits`."""
    states = np.zeros(grid.shape, np.uint8)
    _mark(states, indices(grid, points_xyz), OCCUPIED)
    return OccupancyGrid(grid, states)


def hits_batch(grids: Sequence[Grid], clouds: Sequence[Any]) -> NDArray[np.uint8]:
    """Twin of `hits_batch`."""
    pairs = zip(grids, clouds, strict=True)
    return np.stack([hits(grid, cloud).occupied for grid, cloud in pairs]).astype(np.uint8)


def trace(
    grid: Grid, origins_xyz: ArrayLike, ends_xyz: ArrayLike, returned: ArrayLike | None = None
) -> OccupancyGrid:
    """Twin of `Grid.trace`."""
    ends = np.asarray(ends_xyz, dtype=np.float64)
    origins = np.broadcast_to(np.asarray(origins_xyz, dtype=np.float64), ends.shape)
    states = np.zeros(grid.shape, np.uint8)
    for start in range(0, len(ends), 1024):
        few = slice(start, start + 1024)
        middles, lengths = pieces(grid, origins[few], ends[few])
        _mark(states, indices(grid, middles[lengths > SHORTEST]), FREE)
    hit = ends if returned is None else ends[np.asarray(returned)]
    _mark(states, indices(grid, hit), OCCUPIED)
    return OccupancyGrid(grid, states)


def pieces(
    grid: Grid, origins_xyz: NDArray[np.float64], ends_xyz: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cut beams wherever they can meet a boundary.

    Args:
        grid: Cylindrical or rectangular.
        origins_xyz: (n, 3) [m].
        ends_xyz: (n, 3) [m].

    Returns:
        (n, p, 3) [m] the middle of each piece, and (n, p) its share of the beam.
    """
    along = ends_xyz - origins_xyz
    about = origins_xyz - np.asarray(grid.centre_xyz)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if isinstance(grid, CylindricalGrid):
            meetings = _cylinder_meetings(grid, about, along)
        else:
            meetings = _box_meetings(_rectangular(grid), about, along)
    ends = np.broadcast_to([0.0, 1.0], (len(along), 2))
    cuts = np.concatenate([ends, np.where(np.isfinite(meetings), meetings, 0.0)], axis=1)
    cuts = np.sort(np.clip(cuts, 0.0, 1.0), axis=1)
    middles = (cuts[:, 1:] + cuts[:, :-1]) / 2
    return origins_xyz[:, None] + middles[..., None] * along[:, None], np.diff(cuts, axis=1)


def _cylinder_meetings(
    grid: CylindricalGrid, o: NDArray[np.float64], d: NDArray[np.float64]
) -> NDArray[np.float64]:
    rings, sectors, layers = grid.shape
    shells = grid.radius * np.arange(1, rings + 1) / rings
    # |o + t d|² = shell² in the plane: a t² + 2 b t + c = 0, with b² - a c as Lagrange has it,
    # since the difference itself loses all digits far from the axis.
    a = (d[:, :2] ** 2).sum(axis=1, keepdims=True)
    b = (o[:, :2] * d[:, :2]).sum(axis=1, keepdims=True)
    cross = o[:, :1] * d[:, 1:2] - o[:, 1:2] * d[:, :1]
    root = np.sqrt(a * shells**2 - cross**2)
    angles = grid.azimuth_offset + math.tau * np.arange(sectors) / sectors
    planes = np.stack([-np.sin(angles), np.cos(angles)])
    heights = grid.half_height * (2 * np.arange(layers + 1) / layers - 1)
    return np.concatenate(
        [
            (-b - root) / a,
            (-b + root) / a,
            -(o[:, :2] @ planes) / (d[:, :2] @ planes),
            (heights - o[:, 2:]) / d[:, 2:],
        ],
        axis=1,
    )


def _box_meetings(
    grid: RectangularGrid, o: NDArray[np.float64], d: NDArray[np.float64]
) -> NDArray[np.float64]:
    starts, directions = _turned(grid, *o.T), _turned(grid, *d.T)
    return np.concatenate(
        [
            (grid.half_width * (2 * np.arange(cells + 1) / cells - 1) - start[:, None])
            / direction[:, None]
            for cells, start, direction in zip(grid.shape, starts, directions, strict=True)
        ],
        axis=1,
    )


def _turned(
    grid: RectangularGrid,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    z: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    cosine, sine = math.cos(grid.yaw), math.sin(grid.yaw)
    return cosine * x + sine * y, cosine * y - sine * x, z


def _rectangular(grid: Grid) -> RectangularGrid:
    if not isinstance(grid, RectangularGrid):
        raise TypeError(f"no twin of {type(grid).__name__}")
    return grid


def _mark(states: NDArray[np.uint8], cells: NDArray[np.int32], value: int) -> None:
    states[tuple(cells[cells[:, 0] >= 0].T)] = value
