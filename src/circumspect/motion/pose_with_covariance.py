"""A camera pose with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices


@dataclass(frozen=True, eq=False)
class PoseWithCovariance:
    """A pose and the covariance of its right perturbation.

    Attributes:
        T_map_camera: (4, 4) the pose.
        covariance: (6, 6) [rad, m], optical frame.
    """

    T_map_camera: NDArray[np.floating]
    covariance: NDArray[np.floating]

    @property
    def sigmas(self) -> tuple[float, float]:
        """Largest standard deviations of rotation [rad] and translation [m] in any direction."""
        return se3.largest_deviations(self.covariance)

    @property
    def information(self) -> NDArray[np.floating]:
        """(6, 6) inverse covariance."""
        return np.linalg.inv(self.covariance)

    def levelled(
        self, T_base_camera: NDArray[np.floating], covariance: NDArray[np.floating]
    ) -> PoseWithCovariance:
        """The pose given that the robot base stands level at z = 0.

        A Kalman update with roll, pitch and height of the base as a measurement of zero.

        Args:
            T_base_camera: (4, 4) mount of the camera.
            covariance: (3, 3) of roll [rad], pitch [rad] and height [m] of the base.
        """
        error, J = se3.level_errors(self.T_map_camera, T_base_camera)
        gain = self.covariance @ J.T @ np.linalg.inv(J @ self.covariance @ J.T + covariance)
        kept = np.eye(6) - gain @ J
        # Joseph's form stays symmetric and positive.
        updated = kept @ self.covariance @ kept.T + gain @ covariance @ gain.T
        return PoseWithCovariance(self.T_map_camera @ se3_matrices.exp(-gain @ error), updated)
