"""E57: laser scans of several stations, by pye57 (extra `formats`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.ignored_warnings import ignored_warnings

MAX_POINTS = 20_000_000
"""Largest number of points, since packed points may take little space in the file."""
_AXES = ("cartesianX", "cartesianY", "cartesianZ")


def read_e57(path: Path) -> FileShape:
    """Read the points of all scans in their common frame [m]; invalid ones are left out.

    Raises:
        InputError: Not an E57 file, broken, or too many points.
        MissingExtraError: pye57 is not installed.
    """
    try:
        import pye57
    except ImportError as error:
        raise MissingExtraError("pye57, which reads E57,", "formats") from error
    try:
        with ignored_warnings(), pye57.E57(str(path)) as file:
            count = sum(file.get_header(index).point_count for index in range(file.scan_count))
            if count > MAX_POINTS:
                raise InputError(f"has {count} points; {MAX_POINTS} are read: thin it out first")
            scans = [
                file.read_scan(index, ignore_missing_fields=True, transform=True)
                for index in range(file.scan_count)
            ]
    except (InputError, MemoryError, OSError):
        raise
    except Exception as error:  # The library lets through what broken files bring about.
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no readable E57 file ({reason[:200]}); copy it again") from error
    tables = [np.column_stack([scan[axis] for axis in _AXES]) for scan in scans]
    return FileShape(np.concatenate([np.empty((0, 3)), *tables]).astype(np.float64))
