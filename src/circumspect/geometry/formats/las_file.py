"""LAS and LAZ: laser scans, by laspy (extra `formats`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.library_reading import library_reading, require_readable_count

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
    with library_reading("LAS"), laspy.open(path) as reader:
        count = int(reader.header.point_count)
        require_readable_count(count)
        chunks = [_points(chunk) for chunk in reader.chunk_iterator(_CHUNK)]
    points = np.concatenate([np.empty((0, 3)), *chunks])
    if len(points) < count:
        raise InputError(f"ends too early: {count} points announced, {len(points)} found")
    return FileShape(points)


def _points(chunk: Any) -> NDArray[np.float64]:
    return np.stack([np.asarray(axis) for axis in (chunk.x, chunk.y, chunk.z)], axis=1)
