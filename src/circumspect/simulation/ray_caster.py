"""Ray casting into a scene by Embree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import MissingExtraError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import pixel_rays
from circumspect.simulation.scene import Scene


@dataclass(frozen=True, eq=False)
class View:
    """The image of a camera without noise.

    Attributes:
        depth: (height, width) float32 [m] along the optical z axis, NaN where nothing is hit.
        incidence: (height, width) float32 [rad] angle between ray and normal, 0 … π/2.
        surface: (height, width) int32 index into the scene's surfaces, -1 where nothing is hit.
    """

    depth: NDArray[np.float32]
    incidence: NDArray[np.float32]
    surface: NDArray[np.int32]


class RayCaster:
    """Casts rays into one scene; both sides of a triangle are visible."""

    def __init__(self, scene: Scene) -> None:
        """Build the search tree.

        Args:
            scene: The scene; later changes to it have no effect.

        Raises:
            MissingExtraError: Embree is not installed.
        """
        try:
            from embreex.mesh_construction import TriangleMesh as EmbreeMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise MissingExtraError("embreex", "sim") from error
        self.scene = scene
        self._embree = EmbreeScene()
        # The tree references the meshes without owning them.
        self._meshes = [
            EmbreeMesh(
                self._embree,
                np.ascontiguousarray(surface.mesh.vertices_xyz, dtype=np.float32),
                np.ascontiguousarray(surface.mesh.faces, dtype=np.int32),
            )
            for surface in scene.surfaces
        ]

    def view(self, camera: PinholeCamera, T_map_camera: RigidTransform) -> View:
        """The view of `camera` at `T_map_camera`.

        Rays are not normalised: each has length 1 along the optical axis, so that the distance that
        Embree reports in ray lengths is the depth.
        """
        return self.cast(pixel_rays(camera), T_map_camera)

    def cast(self, rays_xyz: NDArray[np.float32], T_map_camera: RigidTransform) -> View:
        """The first hits of rays.

        Args:
            rays_xyz: (height, width, 3) float32, optical frame, with z = 1.
            T_map_camera: Pose of the camera.
        """
        matrix = T_map_camera.as_matrix()
        rays = rays_xyz.reshape(-1, 3) @ matrix[:3, :3].T.astype(np.float32)
        # The binding takes a single origin for a single ray.
        origins = np.empty_like(rays)
        origins[:] = matrix[:3, 3]
        hits = self._embree.run(origins, np.ascontiguousarray(rays), output=1)
        missed = hits["geomID"] < 0
        depth = np.where(missed, np.float32(np.nan), hits["tfar"])
        size = rays_xyz.shape[:2]
        return View(
            depth.reshape(size),
            _incidence(rays, hits["Ng"], missed).reshape(size),
            hits["geomID"].reshape(size),
        )


def _incidence(
    rays: NDArray[np.float32], normals: NDArray[np.float32], missed: NDArray[np.bool_]
) -> NDArray[np.float32]:
    along = np.abs(np.einsum("ij,ij->i", rays, normals))
    lengths = np.sqrt(np.einsum("ij,ij->i", rays, rays) * np.einsum("ij,ij->i", normals, normals))
    with np.errstate(invalid="ignore", divide="ignore"):
        angle = np.arccos(np.clip(along / lengths, 0, 1))
    return np.where(missed, np.float32(np.pi / 2), angle).astype(np.float32)
