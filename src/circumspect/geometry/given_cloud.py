"""What callers hand over where a cloud is wanted."""

from __future__ import annotations

import os

from numpy.typing import ArrayLike

from circumspect.errors import InputError
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh


def as_cloud(points_xyz: PointCloud | ArrayLike) -> PointCloud:
    """A cloud as it is, or the cloud of an array of points.

    Args:
        points_xyz: (n, 3) [m].

    Raises:
        InputError: A mesh or a path; the message says how to make a cloud of it.
        GeometryError: No array of points, see `PointCloud`.
    """
    if isinstance(points_xyz, PointCloud):
        return points_xyz
    refuse_sources(points_xyz)
    return PointCloud(points_xyz)  # pyright: ignore[reportArgumentType]


def refuse_sources(given: object) -> None:
    """Tell those who have what points are made of, but no points yet.

    Raises:
        InputError: It is a mesh, a path or a model of points.
    """
    if isinstance(given, TriangleMesh):
        raise InputError("points are needed, not a mesh; draw some on it: mesh.sampled(20_000)")
    if isinstance(given, str | os.PathLike):
        raise InputError(
            "points are needed, not the path of a file; read it: circumspect.read_cloud(path)"
        )
    if callable(getattr(given, "cloud", None)):
        name = type(given).__name__
        raise InputError(f"points are needed, not an object of {name}; take its points: .cloud()")
