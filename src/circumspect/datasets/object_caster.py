"""Ray casting at an object under varying stretch without rebuilding its search tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.surroundings import MAX_RANGE_M, NOTHING, OBJECT, Hits, incidence_angles
from circumspect.errors import MissingExtraError
from circumspect.geometry import TriangleMesh


class ObjectCaster:
    """First hits on a mesh, by Embree; both sides of a triangle are visible.

    Args:
        mesh: The object.

    Raises:
        MissingExtraError: Embree is not installed.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh as EmbreeMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise MissingExtraError("embreex", "sim") from error
        self.mesh = mesh
        self.corners_xyz = np.stack([mesh.vertices_xyz.min(axis=0), mesh.vertices_xyz.max(axis=0)])
        """(2, 3) [m] smallest and largest coordinates of the mesh."""
        self._embree = EmbreeScene()
        # The tree references the mesh without owning it.
        self._mesh = EmbreeMesh(
            self._embree,
            np.ascontiguousarray(mesh.vertices_xyz, dtype=np.float32),
            np.ascontiguousarray(mesh.faces, dtype=np.int32),
        )

    def hits(
        self,
        origin_xyz: NDArray[np.float64],
        rays_xyz: NDArray[np.float32],
        stretch: NDArray[np.float64],
    ) -> Hits:
        """First hits of rays on the object after it is stretched.

        An affine map preserves order and proportions along a line; the rays are therefore mapped by
        its inverse, not the mesh.

        Args:
            origin_xyz: (3,) [m] origin of the rays.
            rays_xyz: (n, 3) directions of any length.
            stretch: (3,) factors of the axes; a negative one mirrors.
        """
        back = (1.0 / stretch).astype(np.float32)
        rays = np.ascontiguousarray(rays_xyz * back)
        # The binding takes a single origin for a single ray.
        origins = np.empty_like(rays)
        origins[:] = origin_xyz * back
        found = self._embree.run(origins, rays, output=1)
        hit = found["geomID"] >= 0
        # Normals are covectors and are mapped by the inverse.
        normals = np.where(hit[:, None], found["Ng"], np.float32(1.0)) * back
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
        return Hits(
            np.where(hit, found["tfar"], MAX_RANGE_M).astype(np.float32),
            incidence_angles(rays_xyz, np.einsum("ij,ij->i", rays_xyz, normals)),
            np.where(hit, OBJECT, NOTHING).astype(np.uint8),
        )
