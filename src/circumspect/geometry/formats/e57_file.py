"""E57: laser scans of several stations, by pye57 (extra `formats`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from circumspect.errors import MissingExtraError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.library_reading import library_reading, require_readable_count

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
    with library_reading("E57"), pye57.E57(str(path)) as file:
        headers = [file.get_header(index) for index in range(file.scan_count)]
        require_readable_count(sum(header.point_count for header in headers))
        scans = [
            file.read_scan(index, ignore_missing_fields=True, transform=True)
            for index in range(file.scan_count)
        ]
    tables = [np.column_stack([scan[axis] for axis in _AXES]) for scan in scans]
    return FileShape(np.concatenate([np.empty((0, 3)), *tables]).astype(np.float64))
