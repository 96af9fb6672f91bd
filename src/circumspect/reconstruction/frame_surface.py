"""The object's surface in one frame, ready for fusion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.reconstruction import _native
from circumspect.sensing import DepthNoise, RgbdFrame

POINT_BLOCK_PX = 2
"""Points are means over blocks of this side [px]: a quarter of the points, half the noise."""
NORMAL_BLOCK_PX = 4
"""Normals are computed from the means over blocks of this side [px]."""
MAX_DEPTH_JUMP = 0.04
"""Neighbours farther apart than this fraction of their depth are on different surfaces."""
MIN_INCIDENCE_COSINE = 0.2
"""Lower bound of the cosine of the incidence angle; limits the areas of grazing views."""
MAX_RAY_DISTANCE_M = 0.3
"""Rays that pass the object's bounding circle at a larger distance [m] are discarded."""
OBJECT_RAY_STEP = 3
"""One ray per this many object points; `SightRays` thins them over larger cells anyway."""
BACKGROUND_BLOCK_PX = 8
"""One background ray per block of this side [px]."""


@dataclass(frozen=True, eq=False)
class FrameSurface:
    """Points on the object in one frame, map frame.

    Attributes:
        origin_xyz: (3,) [m] position of the camera.
        points_xyz: (n, 3) float64 [m].
        normals_xyz: (n, 3) float32 unit vectors towards the camera.
        areas: (n,) float32 [m²] surface area that each point represents.
        weights: (n,) float32 inverse variance of each point, larger for frontal views.
        background_xyz: (m, 3) float64 [m] points of the frame that are not on the object, sparse.
    """

    origin_xyz: NDArray[np.float64]
    points_xyz: NDArray[np.float64]
    normals_xyz: NDArray[np.float32]
    areas: NDArray[np.float32]
    weights: NDArray[np.float32]
    background_xyz: NDArray[np.float64]

    @classmethod
    def from_frame(
        cls,
        frame: RgbdFrame,
        object_mask: NDArray[np.bool_],
        T_map_camera: RigidTransform,
        noise: DepthNoise | None = None,
    ) -> FrameSurface:
        """Extract the object's surface from a frame.

        Args:
            frame: The frame.
            object_mask: (height, width) True for pixels that show the object.
            T_map_camera: Pose of the camera.
            noise: Noise of the camera; determines the weights.

        Raises:
            ValueError: The mask and the frame differ in size.
        """
        if object_mask.shape != frame.depth.shape:
            raise ValueError(f"a mask of {frame.depth.shape}, not {object_mask.shape}")
        camera, matrix = frame.camera, T_map_camera.as_matrix()
        surface = _native.frame_surface(
            np.ascontiguousarray(frame.depth, np.float32),
            np.ascontiguousarray(object_mask),
            (camera.fx, camera.fy, camera.cx, camera.cy),
            matrix,
            (noise or DepthNoise()).coefficients(camera),
            POINT_BLOCK_PX,
            NORMAL_BLOCK_PX,
            MAX_DEPTH_JUMP,
            MIN_INCIDENCE_COSINE,
        )
        background = frame.at(T_map_camera).sparse_points_map(BACKGROUND_BLOCK_PX, ~object_mask)
        return cls(matrix[:3, 3], *surface, background)

    def transformed(self, T_target_map: RigidTransform) -> FrameSurface:
        """The surface in the target frame."""
        matrix = T_target_map.as_matrix()
        R, t = matrix[:3, :3], matrix[:3, 3]
        return replace(
            self,
            origin_xyz=R @ self.origin_xyz + t,
            points_xyz=self.points_xyz @ R.T + t,
            normals_xyz=self.normals_xyz @ R.T.astype(np.float32),
            background_xyz=self.background_xyz @ R.T + t,
        )

    def rays_near_object(
        self, known_xyz: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Ends of the rays that hit the object or pass close to it.

        Args:
            known_xyz: (k, 3) [m] points of the object from earlier frames.

        Returns:
            (m, 3) [m] ends, and (m,) bool whether they are on the object. Distances are measured
            in the horizontal plane, with the limit `MAX_RAY_DISTANCE_M`.
        """
        centre, radius = _bounding_circle(
            np.concatenate([known_xyz[:, :2], self.points_xyz[:, :2]])
        )
        radius += MAX_RAY_DISTANCE_M
        start = self.origin_xyz[:2] - centre
        along = self.background_xyz[:, :2] - self.origin_xyz[:2]
        lengths = np.maximum(np.einsum("ij,ij->i", along, along), 1e-12)
        # Fraction of each ray at which it is nearest to the centre.
        nearest = np.clip(-(along @ start) / lengths, 0, 1)
        passing = np.hypot(*(start + nearest[:, None] * along).T) < radius
        own = self.points_xyz[::OBJECT_RAY_STEP]
        ends = np.concatenate([own, self.background_xyz[passing]])
        return ends, np.arange(len(ends)) < len(own)


def _bounding_circle(points_xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(2,) [m] centre of the bounding box of (n, 2) points, and their largest distance from it."""
    # Contiguous columns are several times faster than rows of two.
    x, y = np.ascontiguousarray(points_xy.T)
    centre = np.array([x.min() + x.max(), y.min() + y.max()]) / 2
    return centre, float(np.sqrt(((x - centre[0]) ** 2 + (y - centre[1]) ** 2).max()))
