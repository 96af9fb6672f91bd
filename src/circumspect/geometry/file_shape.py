"""What a file of points or faces holds, before it becomes a cloud or a mesh."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry.missing_points import missing_points
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.precision import require_precision
from circumspect.geometry.triangle_mesh import TriangleMesh

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class FileShape:
    """Points, and what the file says about them; nothing is checked yet.

    Attributes:
        points_xyz: (n, 3) float64, in the axes and unit of the file.
        faces: (f, 3) integer indices into the points; None or empty for a mere cloud.
        normals_xyz: (n, 3) or None.
        areas: (n,) or None.
        up: The axis that points up by the format's own convention.
    """

    points_xyz: NDArray[np.float64]
    faces: NDArray[np.int64] | None = None
    normals_xyz: NDArray[np.float64] | None = None
    areas: NDArray[np.float64] | None = None
    up: str = "z"

    @property
    def has_faces(self) -> bool:
        """Whether this is a surface rather than mere points."""
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

        Points with NaN or infinite coordinates, which scanners write for missing ones, are left
        out with a warning that counts them; so are those at the origin, see `missing_points`.

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
    """Without vertices that are not finite, where no face names them."""
    finite = np.logical_and.reduce(np.isfinite(points_xyz), axis=1)
    if finite.all() or not finite[faces].all():
        return points_xyz, faces
    _LOG.warning("ignored %d vertices that are NaN or infinite", int((~finite).sum()))
    return points_xyz[finite], (np.cumsum(finite) - 1)[faces]


def _turned(vectors_xyz: NDArray[np.float64], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotated vectors in an array that nobody else may write to."""
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
