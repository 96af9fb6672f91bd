"""What of a scene a robot can run into."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.simulation.scene import Scene

CELL = 0.04
"""Side of the cells of a footprint [m]."""
STEP_OVER = 0.03
"""What lies lower than this is driven over [m]."""
MOST_SAMPLES = 400_000


def footprint_boxes(scene: Scene, height: float) -> NDArray[np.float64]:
    """Rectangles on the floor that cover all surfaces but those named "floor".

    A robot with a mast can not go below a table top that its mast would hit, so every surface
    counts from `STEP_OVER` to the mast's `height` and stands for a column down to the floor. The
    rectangles are whole cells of `CELL`, so that they reach up to a cell beyond the surface.
    Closed bodies are hollow here: the robot can not get in anyway.

    Args:
        scene: What stands around.
        height: Of the robot [m].

    Returns:
        (n, 4) [m]: smallest x and y, largest x and y.
    """
    rectangles: list[NDArray[np.floating]] = [np.empty((0, 4))]
    for surface in scene.surfaces:
        if surface.name == "floor":
            continue
        mesh = surface.mesh
        count = int(np.clip(mesh.areas.sum() / (CELL / 2) ** 2, 100, MOST_SAMPLES))
        points = np.concatenate([mesh.sampled(count, 0).points_xyz, mesh.vertices_xyz])
        within = points[(points[:, 2] > STEP_OVER) & (points[:, 2] < height)]
        if len(within):
            rectangles.append(_covering(np.floor(within[:, :2] / CELL).astype(np.intp)) * CELL)
    return np.concatenate(rectangles).astype(np.float64)


def _covering(cells: NDArray[np.intp]) -> NDArray[np.int64]:
    """(n, 4) rectangles of whole cells that cover the given (m, 2) cells and no others."""
    low = cells.min(axis=0)
    columns, rows = (int(size) for size in cells.max(axis=0) - low + 1)
    free = np.zeros((columns, rows), dtype=bool)
    free[tuple((cells - low).T)] = True
    found = []
    while free.any():
        x, y = divmod(int(free.argmax()), rows)
        ends = np.flatnonzero(~free[x, y:])
        y_end = int(y + ends[0]) if len(ends) else rows
        full = free[x:, y:y_end].all(axis=1)
        x_end = int(x + full.argmin()) if not full.all() else columns
        free[x:x_end, y:y_end] = False
        found.append((x, y, x_end, y_end))
    return np.array(found) + np.tile(low, 2)
