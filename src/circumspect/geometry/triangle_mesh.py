"""A surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry.point_cloud import PointCloud


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles over shared vertices; arrays are read-only.

    Attributes:
        vertices_xyz: (v, 3) float64 [m], finite.
        faces: (f, 3) int64 indices into the vertices, f >= 1.

    Raises:
        GeometryError: Wrong shapes, no faces, indices out of range, or a surface of no area.
    """

    vertices_xyz: NDArray[np.float64]
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices_xyz, dtype=np.float64)
        faces = np.array(self.faces, dtype=np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise GeometryError(f"vertices must have shape (v, 3), not {vertices.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise GeometryError(f"faces must have shape (f, 3), not {faces.shape}")
        if len(faces) == 0:
            raise GeometryError("the mesh has no faces")
        if not np.isfinite(vertices).all():
            raise GeometryError("the mesh has NaN or infinite vertices")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise GeometryError(f"faces name vertices outside 0 … {len(vertices) - 1}")
        vertices.flags.writeable = False
        faces.flags.writeable = False
        object.__setattr__(self, "vertices_xyz", vertices)
        object.__setattr__(self, "faces", faces)

    @property
    def corners_xyz(self) -> NDArray[np.float64]:
        """(f, 3, 3) [m]: the three corners of each triangle."""
        return self.vertices_xyz[self.faces]

    @property
    def areas(self) -> NDArray[np.float64]:
        """(f,) [m²]: the area of each triangle."""
        a, b, c = np.moveaxis(self.corners_xyz, 1, 0)
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)

    def sampled(self, count: int, rng: np.random.Generator | int = 0) -> PointCloud:
        """Points drawn evenly over the surface, with the normals of their triangles.

        Args:
            count: How many points.
            rng: A generator or a seed.

        Raises:
            GeometryError: All triangles have no area.
        """
        rng = np.random.default_rng(rng)
        areas = self.areas
        total = float(areas.sum())
        if not total > 0:
            raise GeometryError(
                "the mesh has no area: all its points lie on a line or in one place"
            )
        # Stratified along the cumulated area: less clumping than independent draws.
        steps = (np.arange(count) + rng.random(count)) * (total / count)
        chosen = np.searchsorted(np.cumsum(areas), steps, side="right").clip(max=len(areas) - 1)
        a, b, c = np.moveaxis(self.corners_xyz[chosen], 1, 0)
        u, v = rng.random((2, count, 1))
        fold = u + v > 1
        u, v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return PointCloud(a + u * (b - a) + v * (c - a), normals_xyz=normals)
