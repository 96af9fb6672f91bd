"""Blocks of cells of nearly equal size everywhere in a grid, to be emptied one at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid


@dataclass(frozen=True)
class Block:
    """Some rows of cells along each axis of a grid, and all cells where they meet.

    Attributes:
        rows: Indices along each of the three axes.
    """

    rows: tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]

    @property
    def cells(self) -> tuple[NDArray[np.intp], ...]:
        """What picks the block out of an array of the grid's shape."""
        return np.ix_(*self.rows)


def occupied_blocks(grid: OccupancyGrid, edge: float) -> list[Block]:
    """The blocks of a grid that hold something.

    In a cylinder there is a block at every azimuth cell, wrapped, so that turning the object by
    whole cells turns its blocks. Near the axis, where sectors are narrow, blocks span more of them.

    Args:
        grid: Occupied or not.
        edge: Of a block, as a share of the grid's radius or half width: above 0, at most 2.

    Raises:
        InputError: An edge out of range.
    """
    if not 0.0 < edge <= 2.0:
        raise InputError(f"the edge of a block must lie in 0 … 2 grid radii, not {edge!r}")
    occupied = grid.occupied
    bounds = grid.grid
    if isinstance(bounds, CylindricalGrid):
        blocks = _in_cylinder(bounds, edge)
    elif isinstance(bounds, RectangularGrid):
        blocks = _in_box(bounds, edge)
    else:
        raise InputError(f"no blocks are known for a grid of type {type(bounds).__name__}")
    return [block for block in blocks if occupied[block.cells].any()]


def _in_cylinder(bounds: CylindricalGrid, edge: float) -> Iterator[Block]:
    radii, azimuths, heights = bounds.shape
    deep = _cells(edge * radii)
    high = _cells(edge * bounds.radius * heights / (2.0 * bounds.half_height))
    for rings in _parts(radii, deep):
        middle = (rings[0] + rings[-1] + 1) / (2.0 * radii)
        wide = min(azimuths, _cells(edge * azimuths / (2.0 * np.pi * middle)))
        for layers in _parts(heights, high):
            for first in range(azimuths if wide < azimuths else 1):
                yield Block((rings, (first + np.arange(wide)) % azimuths, layers))


def _in_box(bounds: RectangularGrid, edge: float) -> Iterator[Block]:
    across, along, up = (_parts(count, _cells(edge * count / 2.0)) for count in bounds.shape)
    for x in across:
        for y in along:
            for z in up:
                yield Block((x, y, z))


def _cells(length: float) -> int:
    return max(1, round(length))


def _parts(count: int, size: int) -> list[NDArray[np.intp]]:
    return [np.arange(first, min(first + size, count)) for first in range(0, count, size)]
