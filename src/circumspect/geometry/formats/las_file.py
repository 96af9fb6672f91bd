"""LAS and LAZ: laser scans, by laspy (extra `formats`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.ignored_warnings import ignored_warnings

MAX_POINTS = 20_000_000
"""Largest number of points, since packed points may take little space in the file."""
_CHUNK = 1_000_000


def read_las(path: Path) -> FileShape:
    """Read the coordinates of all points, scaled and shifted by the header.

    Raises:
        InputError: Not a LAS file, truncated, or too many points.
        MissingExtraError: laspy is not installed.
    """
    try:
        import laspy
    except ImportError as error:
        raise MissingExtraError("laspy, which reads LAS and LAZ,", "formats") from error
    try:
        with ignored_warnings(), laspy.open(path) as reader:
            count = int(reader.header.point_count)
            if count > MAX_POINTS:
                raise InputError(f"has {count} points; {MAX_POINTS} are read: thin it out first")
            chunks = [_points(chunk) for chunk in reader.chunk_iterator(_CHUNK)]
    except (InputError, MemoryError, OSError):
        raise
    except Exception as error:  # Broken files bring about errors of several libraries.
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no readable LAS file ({reason[:200]}); copy it again") from error
    points = np.concatenate([np.empty((0, 3)), *chunks])
    if len(points) < count:
        raise InputError(f"ends too early: {count} points announced, {len(points)} found")
    return FileShape(points)


def _points(chunk: Any) -> NDArray[np.float64]:
    return np.stack([np.asarray(axis) for axis in (chunk.x, chunk.y, chunk.z)], axis=1)
