"""A calibrated ceiling camera."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.geometry.given_shapes import require_transform
from circumspect.localization.lens_camera import LensCamera


@dataclass(frozen=True, eq=False)
class FixedCamera(ReadOnlyArrays):
    """Lens and pose of a camera of the intelligent space.

    Attributes:
        name: Unique in its room.
        lens: Intrinsics.
        T_map_camera: Pose of the camera (optical frame).
        covariance: (6, 6) of the pose: rotation [rad] before translation [m], in the camera's
            own frame, T ⊕ (φ, ρ) = T exp(φ, ρ).
        rms_px: Reprojection error of the calibration [px].

    Raises:
        InputError: Missing name, invalid pose, or invalid covariance.
    """

    name: str
    lens: LensCamera
    T_map_camera: RigidTransform
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((6, 6)))
    rms_px: float = 0.0

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("a camera needs a name")
        require_transform(self.T_map_camera, "T_map_camera")
        covariance = np.array(self.covariance, dtype=np.float64)
        if (
            covariance.shape != (6, 6)
            or not np.isfinite(covariance).all()
            or not np.allclose(covariance, covariance.T)
            or np.linalg.eigvalsh(covariance).min() < -1e-12
        ):
            raise InputError(
                f"camera '{self.name}': the covariance must be finite, symmetric, positive and of "
                "shape (6, 6)"
            )
        covariance.flags.writeable = False
        object.__setattr__(self, "covariance", covariance)

    @property
    def position_xyz(self) -> NDArray[np.float64]:
        """(3,) [m] in map."""
        return self.T_map_camera.translation

    def seen_from_camera(self, points_xyz: ArrayLike) -> NDArray[np.float64]:
        """(n, 3) [m] map to (n, 3) [m] optical frame."""
        return self.T_map_camera.inv().apply(np.asarray(points_xyz, dtype=np.float64))

    def project(self, points_xyz: ArrayLike) -> NDArray[np.float64]:
        """(n, 3) [m] map to (n, 2) [px]; see `LensCamera.project`."""
        return self.lens.project(self.seen_from_camera(points_xyz))

    def on_plane(self, pixels_uv: ArrayLike, height: float) -> NDArray[np.float64]:
        """Intersection of the rays of pixels with a horizontal plane.

        Args:
            pixels_uv: (n, 2) [px].
            height: Height of the plane in map [m].

        Returns:
            (n, 2) [m] in map; NaN for rays that do not meet it in front of the camera.
        """
        flat = self.lens.rays_xy(pixels_uv)
        rays = self.T_map_camera.rotation.apply(np.column_stack([flat, np.ones(len(flat))]))
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (height - self.position_xyz[2]) / rays[:, 2]
        far = np.where(far > 0, far, np.nan)
        return self.position_xyz[:2] + far[:, None] * rays[:, :2]

    def outline_xy(self, height: float, steps: int = 8) -> NDArray[np.float64]:
        """(n, 2) closed outline of the visible part of a horizontal plane [m]."""
        w, h = self.lens.size
        along = np.linspace(0, 1, steps, endpoint=False)
        zero, one = np.zeros(steps), np.ones(steps)
        u = np.concatenate([along, one, 1 - along, zero])
        v = np.concatenate([zero, along, one, 1 - along])
        edge = self.on_plane(np.column_stack([u * (w - 1), v * (h - 1)]), height)
        return np.concatenate([edge, edge[:1]])
