"""Translation, rotation, mirroring and joining of meshes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from circumspect.geometry import TriangleMesh

SLIVER = 1e-10
"""[m²] triangles below this area are left out."""


def joined(parts: Sequence[TriangleMesh]) -> TriangleMesh:
    """One mesh of all parts, without cutting or merging where they meet."""
    starts = np.cumsum([0] + [len(part.vertices_xyz) for part in parts[:-1]])
    return TriangleMesh(
        np.concatenate([part.vertices_xyz for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
    )


def moved(mesh: TriangleMesh, offset: ArrayLike) -> TriangleMesh:
    """The mesh shifted by (3,) [m]."""
    return TriangleMesh(mesh.vertices_xyz + np.asarray(offset), mesh.faces)


def turned(
    mesh: TriangleMesh, angle: float, axis: str = "z", pivot: ArrayLike = (0.0, 0.0, 0.0)
) -> TriangleMesh:
    """The mesh turned about an axis through a point.

    Args:
        mesh: What to turn.
        angle: [rad], counter-clockwise as seen against the axis.
        axis: "x", "y" or "z".
        pivot: (3,) [m] a point on the axis.
    """
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[j, i] = np.sin(angle)
    matrix[i, j] = -matrix[j, i]
    centre = np.asarray(pivot)
    return TriangleMesh((mesh.vertices_xyz - centre) @ matrix.T + centre, mesh.faces)


def mirrored(mesh: TriangleMesh, axis: str = "x") -> TriangleMesh:
    """The mesh seen in a mirror through the origin, its faces still turned outwards."""
    flip = np.where(np.arange(3) == "xyz".index(axis), -1.0, 1.0)
    return TriangleMesh(mesh.vertices_xyz * flip, mesh.faces[:, ::-1])


def both_sides(mesh: TriangleMesh, axis: str = "x") -> TriangleMesh:
    """The mesh and its mirror image."""
    return joined([mesh, mirrored(mesh, axis)])


def four_corners(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh and its mirror images in the x and in the y direction."""
    return both_sides(both_sides(mesh, "x"), "y")


def around(mesh: TriangleMesh, count: int, start: float = 0.0) -> TriangleMesh:
    """`count` copies of the mesh turned evenly about the z axis, the first by `start` [rad]."""
    angles = start + np.arange(count) * (2 * np.pi / count)
    return joined([turned(mesh, angle) for angle in angles])


def placed_on_floor(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh on z = 0, the middle of its bounding box on the z axis, without slivers."""
    low, high = mesh.vertices_xyz.min(axis=0), mesh.vertices_xyz.max(axis=0)
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return TriangleMesh(mesh.vertices_xyz - middle, mesh.faces[mesh.areas > SLIVER])
