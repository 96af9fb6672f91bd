"""The camera's motion by its wheels, for whatever their grip turns out to be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose, se3, se3_matrices
from circumspect.geometry.composition import composed, orthonormal
from circumspect.mapping.motion import MOST_VARIANCE, Belief, MotionSettings
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.sensing import Odometry

UNEVEN, ROUNDING = 0.01, 1e-6
"""What an odometry's covariance shrinks by in one direction [share of its growth in the others,
share of the covariance] is put down to rounding."""
PLANAR, BUMPS = [3, 4, 2], [0, 1, 5]
"""Of a change of the base: x, y and yaw; roll, pitch and height."""


@dataclass(frozen=True, eq=False)
class WheelMotion:
    """A motion that is kept as the wheels told it, so that their grip may be learnt later.

    Attributes:
        T_old_new: The motion of wheels that grip fully, optical frame.
        by_shares: (6, 2) its changes by the shares of the way and of the turn that become motion.
        noise: (6, 6) covariance of changes after it [rad, m], but for a steady slip.
        steady: (2, 6, 6) what a steady slip of the way and of the turn adds to that while nothing
            is known of the grip.
    """

    T_old_new: RigidTransform
    by_shares: NDArray[np.float64]
    noise: NDArray[np.float64]
    steady: NDArray[np.float64]

    @classmethod
    def none(cls) -> WheelMotion:
        """No motion, known exactly."""
        return cls(
            RigidTransform.identity(), np.zeros((6, 2)), np.zeros((6, 6)), np.zeros((2, 6, 6))
        )

    def then(self, step: WheelMotion) -> WheelMotion:
        """This motion and another one after it."""
        back = se3.adjoint(step.T_old_new.inv())
        return WheelMotion(
            composed(self.T_old_new, step.T_old_new),
            back @ self.by_shares + step.by_shares,
            back @ self.noise @ back.T + step.noise,
            back @ self.steady @ back.T + step.steady,
        )

    def blurred(self, covariance: NDArray[np.floating]) -> WheelMotion:
        """The same, known less well.

        Args:
            covariance: (6, 6) that is added.
        """
        return replace(self, noise=self.noise + covariance)

    def by(self, grip: WheelGrip) -> Belief:
        """The motion behind what the wheels told, to first order in the slip of the way so far."""
        lost = np.array(grip.shares) - 1
        novelty = np.array(grip.novelty) ** 2
        matrix = self.T_old_new.as_matrix() @ se3_matrices.exp(self.by_shares @ lost)
        return Belief(
            orthonormal(matrix),
            self.noise + np.tensordot(novelty, self.steady, axes=1),
        )


def wheel_step(
    before: Odometry,
    now: Odometry,
    mounts: tuple[RigidTransform, RigidTransform],
    settings: MotionSettings,
    unheld: tuple[float, float] = (0.0, 0.0),
) -> WheelMotion:
    """The camera's motion from one frame to the next.

    What a steady slip η costs grows with the whole way L since the scene held the camera: of its
    variance (η L)² a step d adds η² ((L + d)² - L²).

    Args:
        before: Odometry at the last frame.
        now: Odometry at this frame.
        mounts: T_base_camera at both; a head that pans moves the camera, too.
        settings: Bounds of the trust.
        unheld: Way [m] and turn [rad] by the wheels alone before this step.
    """
    told = before.T_odom_base.inverse() @ now.T_odom_base
    way, turned = float(np.hypot(told.x, told.y)), abs(told.yaw)
    shift = settings.least_shift + settings.slip * way
    spin = settings.least_turn + settings.slip * turned
    base = np.zeros((6, 6))
    base[np.ix_(PLANAR, PLANAR)] = _grown(before, now) + np.diag([shift, shift, spin]) ** 2
    base[BUMPS, BUMPS] = settings.bump_turn**2, settings.bump_turn**2, settings.bump_height**2
    steady = np.zeros((2, 6, 6))
    steady[[0, 1], [3, 2], [3, 2]] = 2 * settings.slip**2 * np.array(unheld) * [way, turned]
    first, second = (mount.as_matrix() for mount in mounts)
    to_camera = se3_matrices.adjoint(se3_matrices.inverse(second))
    return WheelMotion(
        orthonormal(se3_matrices.inverse(first) @ told.as_matrix() @ second),
        to_camera @ _by_shares(told),
        to_camera @ base @ to_camera.T,
        to_camera @ steady @ to_camera.T,
    )


def _by_shares(told: PlanarPose) -> NDArray[np.float64]:
    """(6, 2) changes of the base after a motion (a xy, b yaw) by its shares a and b."""
    cosine, sine = np.cos(told.yaw), np.sin(told.yaw)
    changes = np.zeros((6, 2))
    changes[3:5, 0] = cosine * told.x + sine * told.y, cosine * told.y - sine * told.x
    changes[2, 1] = told.yaw
    return changes


def _grown(before: Odometry, now: Odometry) -> NDArray[np.float64]:
    """(3, 3) what the odometry's covariance grew by [m, rad], in the base's frame now.

    Where that has a negative eigenvalue, it is not that of dead reckoning, but a constant, or one
    of other poses than it comes with. What is left of the difference of two large numbers would
    mean nothing; it is zero then, and the slip alone tells what a step is worth.
    """
    grown = now.growth_since(before)
    values, vectors = np.linalg.eigh((grown + grown.T) / 2)
    if values[0] < -UNEVEN * values[-1] - ROUNDING * np.trace(now.covariance):
        return np.zeros((3, 3))
    return vectors * np.clip(values, 0, MOST_VARIANCE) @ vectors.T
