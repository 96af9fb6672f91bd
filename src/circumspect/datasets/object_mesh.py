"""Surfaces from the object files of a set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.farthest_points import evenly_sampled, evenly_thinned
from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud, TriangleMesh, read_mesh, require_extent
from circumspect.geometry.formats.cloud_files import (
    METRIC_SUFFIXES,
    READER_REGISTRY,
    READERS,
    read_surface,
)

OFF_SUFFIXES = (".off", ".OFF")
"""Suffix of ModelNet10's files."""
COMPANIONS = (".mtl", ".bin", ".png", ".jpg", ".jpeg", ".webp", ".ktx2")
"""Suffixes of files that belong to a mesh: materials, textures, buffers."""


@dataclass(frozen=True, eq=False)
class ObjectSample:
    """Points and size of an object in a set.

    Attributes:
        points_xyz: (1024, 3) float32, evenly spread, in units of the longest side.
        side: Longest side in the unit of the file.
        metric: Whether that unit is the metre.
    """

    points_xyz: NDArray[np.float32]
    side: float
    metric: bool


def is_object_file(file: Path) -> bool:
    """Whether there is a reader for the suffix, in lower or upper case; the file is not read."""
    suffix = file.suffix.lower()
    return suffix in READERS or suffix.removeprefix(".") in READER_REGISTRY.names()


def read_object_mesh(file: Path) -> TriangleMesh:
    """Read a mesh with an area.

    Raises:
        InputError: It cannot be read, or has no area; the message names the file.
    """
    mesh = read_mesh(file)
    _require_area(mesh, file)
    return mesh


def require_object(file: Path) -> None:
    """Check that a file holds an object: a mesh with an area, or points that span a shape.

    Raises:
        InputError: The file cannot be read, or contains no object; the message names it.
    """
    _surface(file)


def sample_object(file: Path) -> ObjectSample:
    """Spread points over the mesh in a file, or thin its points.

    Raises:
        InputError: The file cannot be read, or its object has no area or spans no shape; the
            message names it.
    """
    surface = _surface(file)
    metric = file.suffix.lower() in METRIC_SUFFIXES
    if isinstance(surface, TriangleMesh):
        side = float(np.ptp(surface.vertices_xyz, axis=0).max())
        return ObjectSample(evenly_sampled(surface), side, metric)
    side = float(np.ptp(surface.points_xyz, axis=0).max())
    return ObjectSample(evenly_thinned(surface), side, metric)


def _surface(file: Path) -> TriangleMesh | PointCloud:
    surface = read_surface(file)
    if isinstance(surface, TriangleMesh):
        _require_area(surface, file)
        return surface
    try:
        require_extent(surface)
    except GeometryError as error:
        raise InputError(f"{file}: {error}") from error
    return surface


def _require_area(mesh: TriangleMesh, file: Path) -> None:
    try:
        mesh.chosen_by_area(1)
    except GeometryError as error:
        raise InputError(f"{file}: {error}") from error
