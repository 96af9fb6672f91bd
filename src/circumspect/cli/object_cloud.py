"""Reading the point cloud of an object's file with its unit, for several commands."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid

Unit = Literal["m", "cm", "mm", "in", "unknown"]
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}


def object_cloud(
    file: Path, up: str | None, samples: int, unit_m: float | None, reader: str | None = None
) -> PointCloud:
    """Read a file without stray points, and print warnings of the library.

    Args:
        file: A mesh or a point cloud.
        up: Axis that points up in it; None and "auto" mean the convention of its format.
        samples: Number of points sampled on a mesh.
        unit_m: Length of a unit of the file [m]; None if the scale is unknown.
        reader: See `read_cloud`.

    Raises:
        InputError: The file can not be read.
    """
    from circumspect.geometry import read_cloud
    from circumspect.geometry.clusters import without_stray_points

    with said_warnings(file):
        cloud = read_cloud(file, up=None if up == "auto" else up, samples=samples, reader=reader)
        return cloud_in_metres(without_stray_points(cloud), unit_m)


@contextmanager
def said_warnings(file: Path) -> Iterator[None]:
    """Print warnings that the library logs, each on a line with the file."""
    log, handler = logging.getLogger("circumspect"), _WarningPrinter(file)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


class _WarningPrinter(logging.Handler):
    def __init__(self, file: Path) -> None:
        super().__init__(logging.WARNING)
        self._file = file

    def emit(self, record: logging.LogRecord) -> None:
        say(f"{self._file}: {record.getMessage()}")


def metres_per_unit(file: Path, unit: Unit | None) -> float | None:
    """Length of one unit of a file [m]; None if the scale is unknown.

    Args:
        file: Its suffix determines the format.
        unit: Value of `--unit`; None means the unit of the format, if it has one.
    """
    if unit is None:
        from circumspect.geometry.formats.cloud_files import METRIC_SUFFIXES

        unit = "m" if file.suffix.lower() in METRIC_SUFFIXES else "unknown"
    return METRES.get(unit)


def unit_shown(unit_m: float | None) -> str:
    """The unit of the result of `cloud_in_metres`, for the axes of pictures."""
    return "file units" if unit_m is None else "m"


def cloud_in_metres(cloud: PointCloud, unit_m: float | None) -> PointCloud:
    """A cloud in metres; unchanged if the scale is unknown.

    Args:
        cloud: Points in the unit of the file.
        unit_m: See `metres_per_unit`.
    """
    if unit_m in (None, 1.0):
        return cloud
    import numpy as np

    return cloud.moved(np.diag([unit_m, unit_m, unit_m, 1.0]))


def grid_in_metres(grid: OccupancyGrid, unit_m: float | None) -> OccupancyGrid:
    """A grid with bounds in metres; unchanged if the scale is unknown.

    Args:
        grid: Grid with bounds in the unit of the file.
        unit_m: See `metres_per_unit`.

    Raises:
        InputError: The size of the object is implausible for a room.
    """
    if unit_m is None or not grid.occupied.any():
        return grid
    from circumspect.classification.cloud_checks import require_plausible_size
    from circumspect.geometry import PointCloud
    from circumspect.grid import OccupancyGrid
    from circumspect.grid.cell_centres import occupied_centres

    scaled = OccupancyGrid(grid.grid.scaled(unit_m), grid.states)
    require_plausible_size(PointCloud(occupied_centres(scaled)))
    return scaled
