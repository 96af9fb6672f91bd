"""A compact mesh: 16 bits per coordinate, without duplicate vertices and degenerate triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError
from circumspect.geometry import TriangleMesh
from circumspect.geometry.frozen_array import ReadOnlyArrays

STEPS = 65535
"""Largest value of a coordinate along the longest side."""


@dataclass(frozen=True, eq=False)
class PackedMesh(ReadOnlyArrays):
    """A quantised mesh with the coordinates `vertices_u16 / 65535 * scale + offset`.

    Attributes:
        vertices_u16: (v, 3) uint16 vertices.
        faces: (f, 3) indices into the vertices.
        offset: (3,) float64 [m] lowest x, y and z.
        scale: Longest side [m].
    """

    vertices_u16: NDArray[np.uint16]
    faces: NDArray[np.integer]
    offset: NDArray[np.float64]
    scale: float

    @classmethod
    def from_mesh(cls, mesh: TriangleMesh) -> PackedMesh:
        """Round to 1/65535 of the longest side.

        Vertices without a triangle and triangles without an area are dropped; coinciding vertices
        are merged.

        Raises:
            GeometryError: No triangle is left.
        """
        used = np.unique(mesh.faces)
        vertices = mesh.vertices_xyz[used]
        low = vertices.min(axis=0)
        scale = float(np.ptp(vertices, axis=0).max())
        if not scale > 0:
            raise GeometryError("the mesh has no extent: all its triangles lie in one place")
        steps = np.rint((vertices - low) / scale * STEPS).astype(np.uint16)
        places, place_of_vertex = _distinct(steps)
        faces = place_of_vertex[np.searchsorted(used, mesh.faces)]
        a, b, c = faces.T
        faces = faces[(a != b) & (b != c) & (c != a)]
        if len(faces) == 0:
            raise GeometryError("no triangle is larger than 1/65535 of the longest side")
        kept, faces = np.unique(faces, return_inverse=True)
        index = np.uint16 if len(kept) <= STEPS + 1 else np.uint32
        return cls(places[kept], faces.reshape(-1, 3).astype(index), low, scale)

    @property
    def nbytes(self) -> int:
        """Bytes of vertices and faces."""
        return self.vertices_u16.nbytes + self.faces.nbytes

    def mesh(self) -> TriangleMesh:
        """The mesh [m], rounded."""
        vertices = self.vertices_u16 / STEPS * self.scale + self.offset
        return TriangleMesh(vertices, self.faces.astype(np.int64))


def _distinct(steps: NDArray[np.uint16]) -> tuple[NDArray[np.uint16], NDArray[np.int64]]:
    """(p, 3) distinct rows in order, and the index of each row among them."""
    x, y, z = steps.astype(np.uint64).T
    keys, place_of_row = np.unique(x << np.uint64(32) | y << np.uint64(16) | z, return_inverse=True)
    columns = [(keys >> np.uint64(shift)).astype(np.uint16) for shift in (32, 16, 0)]
    return np.stack(columns, axis=1), place_of_row
