"""The unit of the coordinates in an object's file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid

Unit = Literal["m", "cm", "mm", "in", "unknown"]
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}


def metres_per_unit(file: Path, unit: Unit | None) -> float | None:
    """How long one unit of a file is [m]; None where its scale is unknown.

    Args:
        file: Its suffix says the format.
        unit: What `--unit` says; None means that of the format, if it has one.
    """
    if unit is None:
        from circumspect.geometry.cloud_files import METRIC_SUFFIXES

        unit = "m" if file.suffix.lower() in METRIC_SUFFIXES else "unknown"
    return METRES.get(unit)


def unit_shown(unit_m: float | None) -> str:
    """The unit of what `cloud_in_metres` gives, for the axes of pictures."""
    return "file units" if unit_m is None else "m"


def cloud_in_metres(cloud: PointCloud, unit_m: float | None) -> PointCloud:
    """A cloud in metres; as it is where its scale is unknown.

    Args:
        cloud: In the file's unit.
        unit_m: See `metres_per_unit`.
    """
    if unit_m in (None, 1.0):
        return cloud
    import numpy as np

    return cloud.moved(np.diag([unit_m, unit_m, unit_m, 1.0]))


def grid_in_metres(grid: OccupancyGrid, unit_m: float | None) -> OccupancyGrid:
    """A grid with bounds in metres; as it is where its scale is unknown.

    Args:
        grid: With bounds in the file's unit.
        unit_m: See `metres_per_unit`.

    Raises:
        InputError: The object would be smaller or larger than anything in a room.
    """
    if unit_m is None or not grid.occupied.any():
        return grid
    from circumspect.classification.plausible_size import require_plausible_size
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid
    from circumspect.grid.cell_centres import occupied_centres

    scaled = OccupancyGrid(grid.grid.scaled(unit_m), grid.states)
    require_plausible_size(PointCloud(occupied_centres(scaled)))
    return scaled
