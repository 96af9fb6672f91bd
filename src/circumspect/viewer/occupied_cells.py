"""Geometry for the 3D view: occupied cells as boxes, grid outline as lines, robot as boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid

SHARE = 0.9
"""Side of a box as a fraction of its cell, so that neighbours can be distinguished."""
CUBE_VERTICES = np.array(
    [[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)], np.float32
)
"""(8, 3) vertices of a cube of side 1 about the origin."""
CUBE_FACES = np.array(
    [triangle
     for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2),
                        (1, 3, 7, 5))
     for triangle in ((a, b, c), (a, c, d))], np.uint32,
)  # fmt: skip
"""(12, 3) triangles of the cube, facing outwards."""
HULL = (0.455, 0.381, 0.20)
"""Length, width and height of the Pioneer's body [m]."""
MAST = 0.03
"""Width of the mast [m]."""
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class CellBoxes:
    """Boxes relative to the grid's centre.

    Attributes:
        cells: (n, 3) indices of the cells.
        middles_xyz: (n, 3) float32 [m] centres.
        sizes: (n, 3) float32 [m] sizes along the axes of each box.
        yaws: (n,) [rad] rotations about the vertical.
    """

    cells: NDArray[np.intp]
    middles_xyz: NDArray[np.float32]
    sizes: NDArray[np.float32]
    yaws: NDArray[np.floating]

    def mesh(self, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """(8 m, 3) [m] vertices and (12 m, 3) faces of the m boxes selected by (n,) bool."""
        count = int(chosen.sum())
        corners = CUBE_VERTICES[None] * self.sizes[chosen][:, None]
        c, s = np.cos(self.yaws[chosen])[:, None], np.sin(self.yaws[chosen])[:, None]
        x, y = corners[..., 0], corners[..., 1]
        turned = np.stack([c * x - s * y, s * x + c * y, corners[..., 2]], axis=-1)
        vertices = (turned + self.middles_xyz[chosen][:, None]).reshape(-1, 3)
        faces = CUBE_FACES[None] + 8 * np.arange(count, dtype=np.uint32)[:, None, None]
        return vertices.astype(np.float32), faces.reshape(-1, 3)


def cell_boxes(grid: OccupancyGrid) -> CellBoxes:
    """The occupied cells as boxes; cells of a cylindrical grid are approximated by boxes."""
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
    """Boxes with centres and axes rotated about the vertical."""
    c, s = np.cos(yaws), np.sin(yaws)
    x, y, z = middles.T
    turned = np.column_stack([c * x - s * y, s * x + c * y, z])
    return CellBoxes(cells, turned.astype(np.float32), (SHARE * sizes).astype(np.float32), yaws)


def outline(grid: OccupancyGrid) -> NDArray[np.float32]:
    """(m, 2, 3) [m] line segments relative to the grid's centre: rims and a few verticals."""
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


def robot_boxes(camera_xyz: NDArray[np.floating]) -> list[Box]:
    """Centres and sizes [m] of boxes for body, mast and camera, base frame.

    Args:
        camera_xyz: (3,) [m] position of the camera, base frame.
    """
    x, y, z = (float(value) for value in camera_xyz)
    top = max(z, 0.3)
    return [
        ((-0.045, 0.0, 0.05 + HULL[2] / 2), HULL),
        ((x, y, (0.25 + top) / 2), (MAST, MAST, top - 0.25)),
        ((x, y, z), (0.14, 0.05, 0.04)),
    ]
