"""Depth images of simulated scans."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.placed_object import PlacedObject
from circumspect.datasets.segmentation_errors import LEAK_STEP, SegmentationErrors
from circumspect.datasets.surroundings import NOTHING, RoomSurroundings
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise

Chance = np.random.Generator
HALF_IMAGE = (tan(radians(29.0)), tan(radians(22.5)))
"""Half width and half height of the Xtion's image at 1 m."""
FOCAL = 570.3
"""Focal length of the Xtion PRO [px]."""
ACROSS = 80
"""Rays across the object; finer than the cells of a grid, coarser than a camera's pixels."""
AROUND = 1.3
"""Size of the rendered window in units of the object's."""
RAYS_A_VIEW = 2500
"""Maximum number of rays per view that are traced for free space."""


@dataclass(frozen=True)
class ScanView:
    """The points and rays of one depth image.

    Attributes:
        points_xyz: (n, 3) [m] the segmented surface, map frame.
        origins_xyz: (m, 3) [m] origins of rays.
        ends_xyz: (m, 3) [m] ends of rays, on the object or behind it.
    """

    points_xyz: NDArray[np.floating]
    origins_xyz: NDArray[np.floating]
    ends_xyz: NDArray[np.floating]

    @classmethod
    def taken(
        cls, caster: ObjectCaster, stretch: NDArray[np.float64], placed: PlacedObject,
        around: RoomSurroundings, view_xyz: NDArray[np.float64], segmentation: SegmentationErrors,
        noise_m: float, rng: Chance,
    ) -> ScanView:  # fmt: skip
        """Render, measure and segment one image.

        Args:
            caster: The object [m], z up.
            stretch: (3,) factors of its axes.
            placed: Box of the object.
            around: Surroundings of the object.
            view_xyz: (3,) [m] position of the camera.
            segmentation: The errors of the scan's segmentation.
            noise_m: Standard deviation of the camera's position [m].
            rng: Random generator.
        """
        camera, R_map_camera = _window(placed, view_xyz, rng)
        rays = camera.rays_xyz.reshape(-1, 3).astype(np.float32) @ R_map_camera.T
        hits = caster.hits(view_xyz, rays, stretch).nearer(around.hits(view_xyz, rays))
        size = camera.height, camera.width
        true = np.where(hits.kind == NOTHING, np.float32(np.nan), hits.depth).reshape(size)
        share = camera.fx / FOCAL  # Noise is specified in pixels of the full image.
        noise = DepthNoise(
            nearest=0.4, farthest=6.0, lateral_sigma=0.8 * share, disparity_step=0.125 * share
        )
        depth = noise.applied(true, hits.incidence.reshape(size), camera, rng)
        # The pose includes the registration error.
        turn = Rotation.from_rotvec(rng.normal(0, 1.0, 3) * noise_m * (0.3, 0.3, 1.0))
        origin = (view_xyz + rng.normal(0, 1.0, 3) * noise_m).astype(np.float32)
        believed = rays @ turn.as_matrix().T.astype(np.float32)
        measured = (believed * depth.reshape(-1, 1) + origin).reshape(*size, 3)
        # An edge pixel that measured the background belongs to the background.
        with np.errstate(invalid="ignore"):
            kind = np.where(np.abs(depth - true) < LEAK_STEP, hits.kind.reshape(size), NOTHING)
        mask = segmentation.mask(kind, depth, measured)
        valid = np.flatnonzero(np.isfinite(depth))
        step = max(1, len(valid) // RAYS_A_VIEW)
        ends = measured.reshape(-1, 3)[valid[rng.integers(step) :: step]]
        return cls(measured[mask], np.broadcast_to(origin, ends.shape), ends)


def _window(
    placed: PlacedObject, view_xyz: NDArray[np.float64], rng: Chance
) -> tuple[PinholeCamera, NDArray[np.float32]]:
    """The part of the camera's image around the object, at the required resolution.

    Returns:
        The camera of that part and `R_map_camera`.
    """
    aim = placed.middle + rng.uniform(-0.3, 0.3, 3) * placed.half
    forward = aim - view_xyz
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= max(float(np.linalg.norm(right)), 1e-6)
    R_map_camera = np.column_stack([right, np.cross(forward, right), forward]).astype(np.float32)
    seen = R_map_camera.T @ (placed.middle - view_xyz)
    spread = AROUND * placed.radius / max(seen[2], 0.1)
    low = np.maximum(seen[:2] / max(seen[2], 0.1) - spread, -np.array(HALF_IMAGE))
    high = np.minimum(seen[:2] / max(seen[2], 0.1) + spread, HALF_IMAGE)
    focal = min(ACROSS / (spread * 2 / AROUND), FOCAL)
    width, height = np.maximum(np.ceil((high - low) * focal).astype(int), 8)
    camera = PinholeCamera(
        int(width), int(height), focal, focal, float(-low[0] * focal), float(-low[1] * focal)
    )
    return camera, R_map_camera
