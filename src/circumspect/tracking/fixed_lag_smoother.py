"""Fixed-lag smoother of the most recent camera poses and the odometry scale.

Gauss-Newton minimises the cost of a window; see `smoother_window`. Poses that leave the window are
marginalised into its prior (Sibley, Matthies and Sukhatme, "Sliding window filter with application
to planetary landing", Journal of Field Robotics 2010).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from circumspect.geometry import se3_matrices
from circumspect.motion import PoseWithCovariance, RelativeMotion
from circumspect.tracking.smoother_window import (
    NOT_LEVEL,
    UNMEASURED,
    LevelFactor,
    PoseFactor,
    Stack,
    Window,
    WindowPrior,
)

LAG = 15
"""Number of poses in the window."""
MAX_ITERATIONS, CONVERGED = 5, 2e-4
"""Maximum number of Gauss-Newton steps, and the step at convergence [rad, m]."""


@dataclass(frozen=True, eq=False)
class FixedLagSmoother:
    """Estimate of the poses in the window and of the odometry scale.

    Immutable: `extended` returns a new one, so that hypotheses can share a past.

    Attributes:
        window: Variables and factors.
        covariance: (8, 8) marginal covariance of the last pose [rad, m] and of the scale.
    """

    window: Window
    covariance: Stack

    @classmethod
    def from_pose(
        cls,
        T_map_camera: Stack,
        covariance: Stack,
        scale_sigma: float,
        scale: Stack | None = None,
    ) -> Self:
        """Start with a single pose.

        Args:
            T_map_camera: (4, 4) the pose.
            covariance: (6, 6) of right perturbations [rad, m].
            scale_sigma: Standard deviation of the odometry scale.
            scale: (2,) initial odometry scale; None means 1.
        """
        known = np.zeros((8, 8))
        known[:6, :6] = covariance
        known[6:, 6:] = np.eye(2) * scale_sigma**2
        scale = np.ones(2) if scale is None else scale
        prior = WindowPrior(T_map_camera, scale, np.linalg.inv(known))
        return cls(Window.from_prior(prior), known)

    @property
    def T_map_camera(self) -> Stack:
        """(4, 4) the last pose."""
        return self.window.poses[-1]

    @property
    def scale(self) -> Stack:
        """(2,) estimated odometry scale, of distance and rotation."""
        return self.window.scale

    @property
    def pose(self) -> PoseWithCovariance:
        """The last pose."""
        return PoseWithCovariance(self.T_map_camera, self.covariance[:6, :6])

    def predicted(self, motion: RelativeMotion) -> PoseWithCovariance:
        """The predicted pose after a motion."""
        change = motion.by_scale @ (self.scale - 1)
        T_map_camera = self.T_map_camera @ motion.T_before_now @ se3_matrices.exp(change)
        back = se3_matrices.adjoint(se3_matrices.inverse(motion.T_before_now))
        J = np.hstack([back, motion.by_scale])
        return PoseWithCovariance(T_map_camera, J @ self.covariance @ J.T + motion.covariance)

    def recent_motion(self, poses: int) -> Stack:
        """(4, 4) motion over the last `poses` steps, at most over the window."""
        first = self.window.poses[max(0, len(self.window.poses) - 1 - poses)]
        return se3_matrices.inverse(first) @ self.T_map_camera

    def transformed(self, T_new_old: Stack) -> FixedLagSmoother:
        """The estimate in another or corrected map frame."""
        return replace(self, window=self.window.transformed(T_new_old))

    def extended(
        self,
        motion: RelativeMotion,
        T_map_camera: Stack,
        measured: PoseFactor = UNMEASURED,
        level: LevelFactor | None = None,
    ) -> FixedLagSmoother:
        """The estimate with one more pose.

        Args:
            motion: From the last pose.
            T_map_camera: (4, 4) initial value of the new pose.
            measured: Factor of the pose that a scan measured.
            level: Factor of the level base; None if the mount is unknown.
        """
        level = NOT_LEVEL if level is None else level
        window = self.window.with_pose(T_map_camera, motion, measured, level)
        covariance = self.covariance
        for _ in range(MAX_ITERATIONS):
            step, covariance = window.gauss_newton_step()
            window = window.moved(step)
            if np.abs(step).max() < CONVERGED:
                break
        if len(window.poses) > LAG:
            window = window.without_oldest()
        return FixedLagSmoother(window, covariance)
