"""The content of a file of points or faces, before it becomes a cloud or a mesh."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh

_LOG = logging.getLogger(__name__)
MIN_ORIGIN_SHARE = 0.01
"""More exact copies of the origin than this mark holes in an organised cloud."""
MIN_ORIGIN_COUNT = 16
MIN_STEPS = 64
"""Steps along the longest side of an object; the classifier's grid has as many cells."""


@dataclass(frozen=True, eq=False)
class FileShape:
    """Points and further content of a file; nothing is checked yet.

    Attributes:
        points_xyz: (n, 3) float64, in the axes and unit of the file.
        faces: (f, 3) integer indices into the points; None or empty for a cloud.
        normals_xyz: (n, 3) or None.
        areas: (n,) or None.
        up: The axis that points up, by the convention of the format.
    """

    points_xyz: NDArray[np.float64]
    faces: NDArray[np.int64] | None = None
    normals_xyz: NDArray[np.float64] | None = None
    areas: NDArray[np.float64] | None = None
    up: str = "z"

    @property
    def has_faces(self) -> bool:
        """Whether this is a surface, not only points."""
        return self.faces is not None and len(self.faces) > 0

    def mesh(self, rotation: NDArray[np.float64]) -> TriangleMesh:
        """The surface, turned by a (3, 3) rotation.

        Raises:
            GeometryError: No faces, faces and vertices that do not fit together, or coordinates
                that are too coarse.
        """
        if self.faces is None or len(self.faces) == 0:
            raise GeometryError("has no faces; a mesh is needed here, not mere points")
        points, faces = _used_vertices(self.points_xyz, self.faces)
        require_precision(points)
        return TriangleMesh(_turned(points, rotation), faces)

    def cloud(self, rotation: NDArray[np.float64]) -> PointCloud:
        """The points themselves, turned by a (3, 3) rotation.

        Points with NaN or infinite coordinates, which scanners write for missing ones, are left out
        with a warning. So are those at the origin, see `missing_points`.

        Raises:
            GeometryError: No points, only missing ones, or too coarse ones.
        """
        shape = self._without_missing_points()
        require_precision(shape.points_xyz)
        normals = None if shape.normals_xyz is None else _unit(shape.normals_xyz)
        return PointCloud(
            _turned(shape.points_xyz, rotation),
            areas=shape.areas,
            normals_xyz=None if normals is None else _turned(normals, rotation),
        )

    def _without_missing_points(self) -> FileShape:
        valid = ~missing_points(self.points_xyz)
        missing = len(valid) - int(valid.sum())
        if missing == 0:
            return self
        if missing == len(valid):
            raise GeometryError(f"all {missing} points are invalid (NaN or infinite)")
        return FileShape(
            self.points_xyz[valid],
            normals_xyz=None if self.normals_xyz is None else self.normals_xyz[valid],
            areas=None if self.areas is None else self.areas[valid],
            up=self.up,
        )


def side_by_side(
    columns: Mapping[str, NDArray[Any]], names: tuple[str, ...]
) -> NDArray[np.float64] | None:
    """Named columns of a file as one (n, len(names)) array; None where one is missing.

    Raises:
        InputError: A column that holds several values a point.
    """
    if not all(name in columns for name in names):
        return None
    joined = np.empty((len(columns[names[0]]), len(names)))
    for index, name in enumerate(names):
        if columns[name].ndim != 1:
            raise InputError(f"field {name!r} holds several values a point; one is needed")
        joined[:, index] = columns[name]
    return joined


def _used_vertices(
    points_xyz: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Remove vertices that are not finite, if no face uses them."""
    finite = np.logical_and.reduce(np.isfinite(points_xyz), axis=1)
    if finite.all() or not finite[faces].all():
        return points_xyz, faces
    _LOG.warning("ignored %d vertices that are NaN or infinite", int((~finite).sum()))
    return points_xyz[finite], (np.cumsum(finite) - 1)[faces]


def _turned(vectors_xyz: NDArray[np.float64], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotated vectors in a read-only array."""
    if np.array_equal(rotation, np.eye(3)):
        turned = np.array(vectors_xyz, dtype=np.float64) if _shared(vectors_xyz) else vectors_xyz
    else:
        turned = vectors_xyz @ rotation.T
    turned.flags.writeable = False
    return turned


def _shared(array: NDArray[np.float64]) -> bool:
    return array.base is not None or array.dtype != np.float64


def _unit(normals_xyz: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Normals at length 1; None where some have no direction."""
    longest = np.abs(normals_xyz).max(axis=1, keepdims=True)
    if not (np.isfinite(longest).all() and (longest > 0).all()):
        _LOG.warning("ignored the normals: some are zero or not finite")
        return None
    scaled = normals_xyz / longest
    return scaled / np.linalg.norm(scaled, axis=1, keepdims=True)


def missing_points(points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mask of points that are NaN or infinite, or one of many exactly at the origin.

    Sensors that cannot write NaN put missing measurements at (0, 0, 0). A warning in the log
    counts both kinds.

    Args:
        points_xyz: (n, 3).

    Returns:
        (n,) True for a missing point; never all because of the origin.
    """
    missing = ~np.logical_and.reduce(np.isfinite(points_xyz), axis=1)
    if count := int(missing.sum()):
        _LOG.warning("ignored %d of %d points that are NaN or infinite", count, len(missing))
    origin = np.logical_and.reduce(points_xyz == 0, axis=1)
    count = int(origin.sum())
    enough = max(MIN_ORIGIN_COUNT, MIN_ORIGIN_SHARE * len(origin))
    if not enough <= count < len(origin) - int(missing.sum()):
        return missing
    _LOG.warning("ignored %d of %d points at (0, 0, 0): no measurement", count, len(origin))
    return np.logical_or(missing, origin)


def require_precision(points_xyz: NDArray[np.float64]) -> None:
    """Refuse an object so far from the origin that single precision loses its shape.

    Survey coordinates (easting, northing) in float32 are rounded to half a metre: a chair becomes a
    pillar or a plate, which would be classified with confidence.

    Args:
        points_xyz: (n, 3), n >= 1; values that are not finite are ignored.

    Raises:
        GeometryError: All coordinates are single precision, whose steps there are too coarse.
    """
    farthest = float(np.abs(points_xyz).max(initial=0.0))
    if not 0 < farthest < np.finfo(np.float32).max:
        return
    size = float(np.ptp(points_xyz, axis=0).max())
    step = float(np.spacing(np.float32(farthest)))
    if size == 0 or step * MIN_STEPS <= size:
        return
    if (points_xyz == points_xyz.astype(np.float32)).all():
        raise GeometryError(
            f"the object is {size:.3g} wide and {farthest:.3g} away from the origin, where single "
            f"precision has steps of {step:.3g}; subtract an offset in double precision, then save"
        )
