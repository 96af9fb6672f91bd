"""Checks of arguments that should be a cloud or a rigid transform."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from circumspect.errors import InputError
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform


def as_cloud(points_xyz: PointCloud | ArrayLike) -> PointCloud:
    """A cloud unchanged, or the cloud of an array of points.

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
    """Report how to get points from an object that has none.

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


def require_transform(given: object, name: str) -> RigidTransform:
    """One pose, or a batch of them, as SciPy's `RigidTransform`.

    Args:
        given: Of any type.
        name: Name of the argument.

    Raises:
        InputError: It is of another type, such as a (4, 4) matrix.
    """
    from scipy.spatial.transform import RigidTransform

    if isinstance(given, RigidTransform):
        return given
    raise InputError(
        f"{name} must be a SciPy RigidTransform, not {type(given).__name__}; a (4, 4) matrix "
        "becomes one by RigidTransform.from_matrix, a PlanarPose by as_transform"
    )
