r"""Variables and factors of the fixed-lag smoother: recent poses and odometry scale.

The cost of the poses $T_1 \dots T_n$ of a window and of the odometry scale $s$ is

$$\sum_k \rho(\|\log(Z_k(s)^{-1} T_k^{-1} T_{k+1})\|^2_{\Omega_k})
+ \sum_k \rho(\|\log(\hat T_k^{-1} T_k)\|^2_{H_k})
+ \sum_k \|\mathrm{level}(T_k)\|^2_{\Lambda_k} + \|\mathrm{prior}(T_1, s)\|^2$$

with Cauchy's kernel ρ, motions of the odometry $Z_k$, measured poses $\hat T_k$, and roll, pitch
and height of the robot's base in $\mathrm{level}$.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.motion import RelativeMotion
from circumspect.pose_graph.normal_equations import CAUCHY_SCALE
from circumspect.tracking import _native

SCALE_DRIFT = 0.01
"""Standard deviation of the odometry scale's random walk after 1 m and after 1 rad."""

Stack = NDArray[np.floating]


class PoseFactor(NamedTuple):
    """A measured pose.

    Attributes:
        T_map_camera: (4, 4) the pose.
        information: (6, 6) inverse covariance of right perturbations [rad, m]; zero in unmeasured
            directions.
    """

    T_map_camera: Stack
    information: Stack


class LevelFactor(NamedTuple):
    """A robot that stands level at z = 0.

    Attributes:
        T_base_camera: (4, 4) mount of its camera.
        information: (3, 3) inverse covariance of roll [rad], pitch [rad] and height [m].
    """

    T_base_camera: Stack
    information: Stack


UNMEASURED = PoseFactor(np.eye(4), np.zeros((6, 6)))
"""The factor of an unmeasured pose."""
NOT_LEVEL = LevelFactor(np.eye(4), np.zeros((3, 3)))
"""The factor of a camera whose mount is unknown."""


class WindowPrior(NamedTuple):
    """Prior of the window's first pose and of the scale, from all earlier measurements.

    Attributes:
        T_map_camera: (4, 4) the pose.
        scale: (2,) odometry scale, of distance and rotation.
        information: (8, 8) joint inverse covariance.
    """

    T_map_camera: Stack
    scale: Stack
    information: Stack


class WindowFactors(NamedTuple):
    """Stacked factors of n poses.

    Attributes:
        motions: (n - 1, 4, 4) motions between consecutive poses, for a scale of 1.
        by_scale: (n - 1, 6, 2) derivatives of the motions with respect to the scale.
        motion_information: (n - 1, 6, 6) inverse covariances of the motions.
        measured: (n, 4, 4) measured poses.
        measured_information: (n, 6, 6) their information; zero for unmeasured poses.
        mounts: (n, 4, 4) `T_base_camera`.
        level_information: (n, 3, 3) information of roll, pitch and height; zero where the mount
            is unknown.
    """

    motions: Stack
    by_scale: Stack
    motion_information: Stack
    measured: Stack
    measured_information: Stack
    mounts: Stack
    level_information: Stack

    @classmethod
    def of_one_pose(cls) -> Self:
        """The factors of a window with a single, unmeasured pose."""
        motions = (np.empty((0, *shape)) for shape in ((4, 4), (6, 2), (6, 6)))
        return cls(*motions, *(array[None] for array in (*UNMEASURED, *NOT_LEVEL)))


@dataclass(frozen=True, eq=False)
class Window:
    """The variables and factors of the smoother.

    Attributes:
        poses: (n, 4, 4) `T_map_camera`.
        scale: (2,) odometry scale, of distance and rotation.
        prior: Prior of the first pose and of the scale.
        factors: Factors of motions, measured poses and level bases.
    """

    poses: Stack
    scale: Stack
    prior: WindowPrior
    factors: WindowFactors

    @classmethod
    def from_prior(cls, prior: WindowPrior) -> Self:
        """A window with a single pose."""
        return cls(prior.T_map_camera[None], prior.scale, prior, WindowFactors.of_one_pose())

    def with_pose(
        self, T_map_camera: Stack, motion: RelativeMotion, measured: PoseFactor, level: LevelFactor
    ) -> Window:
        """The window with one more pose, at an initial value."""
        information = np.linalg.inv(motion.covariance)
        added = motion.T_before_now, motion.by_scale, information, *measured, *level
        factors = WindowFactors(*map(_appended, self.factors, added))
        return replace(self, poses=_appended(self.poses, T_map_camera), factors=factors)

    def linearised(self, count: int | None = None) -> tuple[Stack, Stack]:
        """The normal equations at the current estimate.

        Args:
            count: Use only the prior and the factors of so many first poses, including the motions
                that start there; None means all.

        Returns:
            (6 m + 2, 6 m + 2) Hessian and (6 m + 2,) gradient of half the cost, for the m poses
            that the factors depend on; the last two rows are the scale's. The kernel's weights are
            treated as constants.
        """
        count = len(self.poses) if count is None else count
        return _native.linearised(
            self.poses, self.scale, *self.prior, *self.factors, CAUCHY_SCALE, count
        )

    def gauss_newton_step(self, count: int | None = None) -> tuple[Stack, Stack]:
        """The step to the minimum of the linearised cost.

        Args:
            count: As in `linearised`.

        Returns:
            (6 m + 2,) changes of the poses [rad, m] and of the scale, and (8, 8) marginal
            covariance of the last pose and of the scale.

        Raises:
            ValueError: The factors do not determine all variables.
        """
        solution, covariance = _native.solved(*self.linearised(count), 8)
        return -solution, covariance

    def moved(self, step: Stack) -> Window:
        """The same factors at another estimate.

        Args:
            step: (6 n + 2,) changes of all poses [rad, m] and of the scale.
        """
        poses = _native.moved(self.poses, step[:-2].reshape(-1, 6))
        return replace(self, poses=poses, scale=self.scale + step[-2:])

    def without_oldest(self) -> Window:
        """The window without its first pose, whose factors become the prior of the second."""
        # Marginalisation: these factors alone determine the second pose and the scale.
        step, covariance = self.gauss_newton_step(1)
        second = self.poses[1] @ se3_matrices.exp(step[6:12])
        # The scale drifts because floors change.
        drift = SCALE_DRIFT**2 * np.linalg.norm(self.factors.by_scale[0], axis=0)
        covariance[[6, 7], [6, 7]] += drift
        prior = WindowPrior(second, self.scale + step[12:], np.linalg.inv(covariance))
        factors = WindowFactors(*(array[1:] for array in self.factors))
        return Window(self.poses[1:], self.scale, prior, factors)

    def transformed(self, T_new_old: Stack) -> Window:
        """The window in another map frame."""
        return replace(
            self,
            poses=T_new_old @ self.poses,
            prior=self.prior._replace(T_map_camera=T_new_old @ self.prior.T_map_camera),
            factors=self.factors._replace(measured=T_new_old @ self.factors.measured),
        )


def _appended(array: Stack, row: Stack) -> Stack:
    return np.concatenate([array, row[None]])
