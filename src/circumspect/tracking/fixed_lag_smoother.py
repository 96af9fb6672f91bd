"""Estimates the most recent poses of a camera and the scale of its odometry together.

Gauss-Newton minimises the cost of a window, see `smoother_window`. Poses that leave the window are
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
"""Poses in the window."""
MAX_ITERATIONS, CONVERGED = 5, 2e-4
"""Gauss-Newton steps at most, and the step [rad, m] below which the estimate has converged."""


@dataclass(frozen=True, eq=False)
class FixedLagSmoother:
    """The estimate over a window.

    It is immutable: `extended` returns a new one, so that hypotheses can share a past.

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
            covariance: (6, 6) of changes after it [rad, m].
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
        """(2,) estimated scale of the odometry: of the distance and of the rotation."""
        return self.window.scale

    @property
    def pose(self) -> PoseWithCovariance:
        """The last pose."""
        return PoseWithCovariance(self.T_map_camera, self.covariance[:6, :6])

    def predicted(self, motion: RelativeMotion) -> PoseWithCovariance:
        """The pose after a motion, before it is measured."""
        change = motion.by_scale @ (self.scale - 1)
        T_map_camera = self.T_map_camera @ motion.T_before_now @ se3_matrices.exp(change)
        back = se3_matrices.adjoint(se3_matrices.inverse(motion.T_before_now))
        J = np.hstack([back, motion.by_scale])
        return PoseWithCovariance(T_map_camera, J @ self.covariance @ J.T + motion.covariance)

    def recent_motion(self, poses: int) -> Stack:
        """(4, 4) the motion since so many poses ago, at most since the first of the window."""
        first = self.window.poses[max(0, len(self.window.poses) - 1 - poses)]
        return se3_matrices.inverse(first) @ self.T_map_camera

    def transformed(self, T_new_old: Stack) -> FixedLagSmoother:
        """The same in another map frame, or in a map that was corrected by this transform."""
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
            measured: What a scan says about it.
            level: The base that the camera is mounted on.
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
