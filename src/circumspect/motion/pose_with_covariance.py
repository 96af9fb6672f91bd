"""Camera poses and motions between frames, with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.geometry import se3, se3_matrices


@dataclass(frozen=True, eq=False)
class RelativeMotion:
    """Motion between two consecutive frames, from odometry or from a motion model.

    The motion for an odometry scale s = (s_translation, s_rotation) is, to first order,
    T exp(G (s - 1)).

    Attributes:
        T_before_now: (4, 4) T, the motion for a scale of 1, optical frame.
        by_scale: (6, 2) G, its derivative with respect to the scale [rad, m]; zero for a motion
            that does not come from odometry.
        covariance: (6, 6) of right perturbations [rad, m].
        source: "odometry", "slipping wheels", "constant velocity" or "standing still".
    """

    T_before_now: NDArray[np.floating]
    by_scale: NDArray[np.floating]
    covariance: NDArray[np.floating]
    source: str = "odometry"

    @property
    def distance(self) -> float:
        """Distance between both positions of the camera [m]."""
        return float(np.linalg.norm(self.T_before_now[:3, 3]))

    @property
    def rotation(self) -> float:
        """Angle between both orientations [rad]."""
        return float(Rotation.from_matrix(self.T_before_now[:3, :3]).magnitude())


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
