"""PTS: laser scans in text, each behind the number of its points."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import IO

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.number_table import read_table
from circumspect.geometry.xyz_file import read_xyz


def read_pts(path: Path) -> FileShape:
    """Read x, y, z of all scans; intensity and colours behind them are passed over.

    A file without counts is read as XYZ.

    Raises:
        InputError: No table of numbers, or fewer points than announced.
    """
    counts: list[int] = []
    with path.open("rb") as stream:
        first = next((line for line in stream if line.strip()), b"")
        if not first.strip().isdigit():
            return read_xyz(path)
        stream.seek(0)
        points = read_table(_rows(stream, counts), columns=3)
    if len(points) != sum(counts):
        raise InputError(
            f"ends too early: {sum(counts)} points announced, {len(points)} found"
            if len(points) < sum(counts)
            else f"holds {len(points)} points, and {sum(counts)} are announced"
        )
    return FileShape(points)


def _rows(stream: IO[bytes], counts: list[int]) -> Iterator[bytes]:
    """Lines of points; the counts between them are collected."""
    for line in stream:
        if line.strip().isdigit():
            counts.append(int(line))
        else:
            yield line
