"""A surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import _native
from circumspect.geometry.frozen_array import ReadOnlyArrays, frozen, require_coordinates
from circumspect.geometry.point_cloud import PointCloud


@dataclass(frozen=True, eq=False)
class TriangleMesh(ReadOnlyArrays):
    """Triangles over shared vertices; arrays are read-only.

    Attributes:
        vertices_xyz: (v, 3) float64 [m], finite.
        faces: (f, 3) int64 indices into the vertices, f >= 1.

    Raises:
        GeometryError: Wrong shapes, no faces, or indices out of range.
    """

    vertices_xyz: NDArray[np.float64]
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        vertices = frozen(self.vertices_xyz)
        require_coordinates(vertices, "vertices")
        faces = np.array(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise GeometryError(f"faces must have shape (f, 3), not {faces.shape}")
        if len(faces) == 0:
            raise GeometryError("the mesh has no faces")
        if faces.dtype.kind not in "iu":
            raise GeometryError(f"faces must be whole numbers, not {faces.dtype}")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise GeometryError(f"faces name vertices outside 0 … {len(vertices) - 1}")
        faces = faces.astype(np.int64, copy=False)
        faces.flags.writeable = False
        object.__setattr__(self, "vertices_xyz", vertices)
        object.__setattr__(self, "faces", faces)

    def __repr__(self) -> str:
        return f"TriangleMesh({len(self.vertices_xyz)} vertices, {len(self.faces)} faces)"

    @property
    def corners_xyz(self) -> NDArray[np.float64]:
        """(f, 3, 3) [m]: the three corners of each triangle."""
        return self.vertices_xyz[self.faces]

    @property
    def areas(self) -> NDArray[np.float64]:
        """(f,) [m²]: the area of each triangle."""
        _, doubled, longest = _native.face_normals(self.vertices_xyz, self.faces)
        return 0.5 * longest**2 * doubled

    def sampled(self, count: int, rng: np.random.Generator | int = 0) -> PointCloud:
        """Sample points evenly over the surface, with the normals of their triangles.

        Args:
            count: Number of points, at least 1.
            rng: A generator or a seed.

        Returns:
            The points, in the order of the triangles.

        Raises:
            GeometryError: All triangles have no area, or `count` is not positive.
        """
        rng = np.random.default_rng(rng)
        normals, shares = self._normals_and_shares()
        chosen = _evenly_chosen(shares, count, rng)
        a, b, c = np.moveaxis(self.vertices_xyz[self.faces[chosen]], 1, 0)
        u, v = rng.random((2, count, 1))
        fold = u + v > 1
        u, v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
        return PointCloud(a + u * (b - a) + v * (c - a), normals_xyz=normals[chosen])

    def chosen_by_area(self, count: int, rng: np.random.Generator | int = 0) -> NDArray[np.int64]:
        """Draw triangles in proportion to their area.

        Args:
            count: Number of draws, at least 1; large triangles repeat.
            rng: A generator or a seed.

        Returns:
            (count,) indices of faces, ascending.

        Raises:
            GeometryError: All triangles have no area, or `count` is not positive.
        """
        return _evenly_chosen(self._normals_and_shares()[1], count, np.random.default_rng(rng))

    def _normals_and_shares(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(f, 3) unit normals, and (f,) fractions of the area: 0 without a normal."""
        normals, doubled, _ = _native.face_normals(self.vertices_xyz, self.faces)
        if not float(doubled.max()) > 0:
            raise GeometryError(
                "the mesh has no area: all its points lie on a line or in one place"
            )
        return normals, doubled


def _evenly_chosen(
    shares: NDArray[np.float64], count: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Stratified along the cumulated area: less clumping than independent draws."""
    if count < 1:
        raise GeometryError(f"at least 1 point must be sampled, not {count}")
    steps = (np.arange(count) + rng.random(count)) / count
    usable = np.flatnonzero(shares)
    cumulated = np.cumsum(shares[usable])
    places = np.searchsorted(cumulated, steps * cumulated[-1], side="right")
    return usable[places.clip(max=len(usable) - 1)]
