"""The cloud of an object's file, as the commands that name or draw it read it."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from circumspect.cli.say import say
from circumspect.cli.unit import cloud_in_metres

if TYPE_CHECKING:
    from circumspect.geometry import PointCloud


def object_cloud(
    file: Path, up: str | None, samples: int, unit_m: float | None, reader: str | None = None
) -> PointCloud:
    """Read a file, leave out stray points, and say what was ignored.

    Args:
        file: A mesh or a cloud.
        up: The axis that points up in it; None and "auto" take the convention of its format.
        samples: Points drawn from a mesh.
        unit_m: Length of a unit of the file [m]; None where its scale is unknown.
        reader: As for `read_cloud`.

    Raises:
        InputError: The file can not be read.
    """
    from circumspect.geometry import read_cloud
    from circumspect.geometry.stray_points import without_stray_points

    with said_warnings(file):
        cloud = read_cloud(file, up=None if up == "auto" else up, samples=samples, reader=reader)
        return cloud_in_metres(without_stray_points(cloud), unit_m)


@contextmanager
def said_warnings(file: Path) -> Iterator[None]:
    """Print what the library logs as a warning in lines that name the file."""
    log, handler = logging.getLogger("circumspect"), _Sayer(file)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


class _Sayer(logging.Handler):
    def __init__(self, file: Path) -> None:
        super().__init__(logging.WARNING)
        self._file = file

    def emit(self, record: logging.LogRecord) -> None:
        say(f"{self._file}: {record.getMessage()}")
