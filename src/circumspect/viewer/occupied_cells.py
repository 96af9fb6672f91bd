"""The occupied cells of a grid as boxes, and its outline as lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.viewer.solids import CUBE_FACES, CUBE_VERTICES

SHARE = 0.9
"""A box fills this share of its cell, so that neighbours can be told apart."""


@dataclass(frozen=True, eq=False)
class CellBoxes:
    """Boxes in the frame of the grid's centre.

    Attributes:
        cells: (n, 3) indices of the cells.
        middles_xyz: (n, 3) float32 [m].
        sizes: (n, 3) float32 [m] along the boxes' own axes.
        yaws: (n,) [rad] how they are turned about the vertical.
    """

    cells: NDArray[np.intp]
    middles_xyz: NDArray[np.float32]
    sizes: NDArray[np.float32]
    yaws: NDArray[np.floating]

    def mesh(self, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """(8 m, 3) [m] vertices and (12 m, 3) faces of the m boxes chosen by (n,) bool."""
        count = int(chosen.sum())
        corners = CUBE_VERTICES[None] * self.sizes[chosen][:, None]
        c, s = np.cos(self.yaws[chosen])[:, None], np.sin(self.yaws[chosen])[:, None]
        x, y = corners[..., 0], corners[..., 1]
        turned = np.stack([c * x - s * y, s * x + c * y, corners[..., 2]], axis=-1)
        vertices = (turned + self.middles_xyz[chosen][:, None]).reshape(-1, 3)
        faces = CUBE_FACES[None] + 8 * np.arange(count, dtype=np.uint32)[:, None, None]
        return vertices.astype(np.float32), faces.reshape(-1, 3)


def cell_boxes(grid: OccupancyGrid) -> CellBoxes:
    """The occupied cells; of a cylindrical grid each ring's sector is drawn as a box."""
    cells = np.argwhere(grid.occupied)
    bounds = grid.grid
    if isinstance(bounds, CylindricalGrid):
        return _sectors(bounds, cells)
    assert isinstance(bounds, RectangularGrid)
    size = 2 * bounds.half_width / np.array(bounds.shape)
    middles = (cells + 0.5) * size - bounds.half_width
    return _turned(cells, middles, np.tile(size, (len(cells), 1)), np.full(len(cells), bounds.yaw))


def _sectors(bounds: CylindricalGrid, cells: NDArray[np.intp]) -> CellBoxes:
    rings, sectors, layers = bounds.shape
    across, turn = bounds.radius / rings, 2 * np.pi / sectors
    height = 2 * bounds.half_height / layers
    radii = (cells[:, 0] + 0.5) * across
    azimuths = (cells[:, 1] + 0.5) * turn + bounds.azimuth_offset
    middles = np.column_stack(
        [radii, np.zeros(len(cells)), (cells[:, 2] + 0.5) * height - bounds.half_height]
    )
    sizes = np.column_stack(
        [np.full(len(cells), across), radii * turn, np.full(len(cells), height)]
    )
    return _turned(cells, middles, sizes, azimuths)


def _turned(
    cells: NDArray[np.intp],
    middles: NDArray[np.floating],
    sizes: NDArray[np.floating],
    yaws: NDArray[np.floating],
) -> CellBoxes:
    """Boxes whose middles and axes are turned about the vertical."""
    c, s = np.cos(yaws), np.sin(yaws)
    x, y, z = middles.T
    turned = np.column_stack([c * x - s * y, s * x + c * y, z])
    return CellBoxes(cells, turned.astype(np.float32), (SHARE * sizes).astype(np.float32), yaws)


def outline(grid: OccupancyGrid) -> NDArray[np.float32]:
    """(m, 2, 3) [m] line segments about the grid's centre: rims and a few uprights."""
    bounds = grid.grid
    if isinstance(bounds, CylindricalGrid):
        azimuths = np.linspace(0, 2 * np.pi, 65)
        rim = bounds.radius * np.column_stack([np.cos(azimuths), np.sin(azimuths)])
        half, uprights = bounds.half_height, rim[:-1:8]
    else:
        assert isinstance(bounds, RectangularGrid)
        half = bounds.half_width
        yaws = bounds.yaw + np.radians([45.0, 135.0, 225.0, 315.0, 405.0])
        rim = half * np.sqrt(2) * np.column_stack([np.cos(yaws), np.sin(yaws)])
        uprights = rim[:-1]
    low, high = (np.column_stack([rim, np.full(len(rim), z)]) for z in (-half, half))
    posts = np.stack(
        [np.column_stack([uprights, np.full(len(uprights), z)]) for z in (-half, half)], axis=1
    )
    rings = [np.stack([ring[:-1], ring[1:]], axis=1) for ring in (low, high)]
    return np.concatenate([*rings, posts]).astype(np.float32)
