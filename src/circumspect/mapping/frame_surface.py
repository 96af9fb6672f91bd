"""The surface that one frame shows, ready to be fused."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.sensing import DepthBlocks, DepthNoise, RgbdFrame

BLOCK = 2
"""Points are means over blocks of this side [px]: a quarter of the points, half the noise."""
NORMAL_BLOCK = 4
"""Side of the blocks between which normals are taken [px]."""
GRAZING_COSINE = 0.2
"""Areas are not blown up further than at this cosine of the incidence angle."""
BESIDE = 0.3
"""Rays that pass the object within this distance [m] tell what is free."""
RAY_STEP = 3
"""One ray for each so many points of the object: rays are thinned over larger cells anyway."""
BACKGROUND_BLOCK = 8
"""One ray past the object for each block of this side [px]."""


@dataclass(frozen=True, eq=False)
class FrameSurface:
    """Points of the object in one frame, map frame.

    Attributes:
        origin_xyz: (3,) [m] the camera's place.
        points_xyz: (n, 3) float64 [m].
        normals_xyz: (n, 3) float32 unit vectors towards the camera.
        areas: (n,) float32 [m²] of surface that each point stands for.
        weights: (n,) float32 inverse variance of each point, larger for frontal views.
        behind_xyz: (m, 3) float64 [m] what else the frame shows, sparse.
    """

    origin_xyz: NDArray[np.float64]
    points_xyz: NDArray[np.float64]
    normals_xyz: NDArray[np.float32]
    areas: NDArray[np.float32]
    weights: NDArray[np.float32]
    behind_xyz: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        frame: RgbdFrame,
        object_mask: NDArray[np.bool_],
        T_map_camera: RigidTransform,
        noise: DepthNoise | None = None,
    ) -> FrameSurface:
        """Take the object's surface out of a frame.

        Args:
            frame: The frame.
            object_mask: (height, width) the object's pixels.
            T_map_camera: Where the frame was taken from.
            noise: The camera's noise; weighs near points more than far ones.
        """
        camera, matrix = frame.camera, T_map_camera.as_matrix()
        fine = DepthBlocks.of(frame.depth, camera, BLOCK, object_mask)
        rows, columns = np.nonzero(fine.counts)
        points = fine.points_xyz(rows, columns)
        ratio = NORMAL_BLOCK // BLOCK
        coarse = DepthBlocks.of(frame.depth, camera, NORMAL_BLOCK, object_mask)
        normals = coarse.normals()[rows // ratio, columns // ratio]
        towards = -points / np.sqrt(np.einsum("ij,ij->i", points, points))[:, None]
        normals = np.where(np.isfinite(normals[:, :1]), normals, towards)
        cosine = np.maximum(np.einsum("ij,ij->i", normals, towards), GRAZING_COSINE)
        z = points[:, 2]
        # A pixel's patch perpendicular to its ray shrinks with the ray's angle to the axis.
        facing = -towards[:, 2] * z**2 / (camera.fx * camera.fy) * fine.counts[rows, columns]
        weights = cosine / (noise or DepthNoise()).axial_sigma(z) ** 2
        return cls(
            matrix[:3, 3],
            points @ matrix[:3, :3].T.astype(np.float32) + matrix[:3, 3],
            normals @ matrix[:3, :3].T.astype(np.float32),
            facing / cosine,
            weights,
            frame.at(T_map_camera).sparse_points_map(BACKGROUND_BLOCK, ~object_mask),
        )

    def moved(self, T_target_map: RigidTransform) -> FrameSurface:
        """The same in another frame."""
        matrix = T_target_map.as_matrix()
        R, t = matrix[:3, :3], matrix[:3, 3]
        return replace(
            self,
            origin_xyz=R @ self.origin_xyz + t,
            points_xyz=self.points_xyz @ R.T + t,
            normals_xyz=self.normals_xyz @ R.T.astype(np.float32),
            behind_xyz=self.behind_xyz @ R.T + t,
        )

    def rays_beside(
        self, known_xyz: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Where the rays end that tell something about the object's surroundings.

        Args:
            known_xyz: (k, 3) [m] points of the object from earlier frames.

        Returns:
            (m, 3) [m] ends, and (m,) bool whether they are on the object. Rays that pass the
            object at more than `BESIDE` are left out.
        """
        axis, reach = _round(np.concatenate([known_xyz[:, :2], self.points_xyz[:, :2]]))
        reach += BESIDE
        start, along = self.origin_xyz[:2] - axis, self.behind_xyz[:, :2] - self.origin_xyz[:2]
        lengths = np.maximum(np.einsum("ij,ij->i", along, along), 1e-12)
        share = np.clip(-(along @ start) / lengths, 0, 1)
        passing = np.hypot(*(start + share[:, None] * along).T) < reach
        own = self.points_xyz[::RAY_STEP]
        ends = np.concatenate([own, self.behind_xyz[passing]])
        return ends, np.arange(len(ends)) < len(own)


def _round(points_xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(2,) [m] the middle of the box round (n, 2) points, and their largest distance from it."""
    # Each column in one piece: several times faster than rows of two.
    x, y = np.ascontiguousarray(points_xy.T)
    middle = np.array([x.min() + x.max(), y.min() + y.max()]) / 2
    return middle, float(np.sqrt(((x - middle[0]) ** 2 + (y - middle[1]) ** 2).max()))
