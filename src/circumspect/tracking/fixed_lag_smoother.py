r"""The most recent poses of a camera and the scale of its odometry, estimated together.

The smoother minimises, over the poses $T_1 \dots T_n$ of a window and the odometry scale $s$,

$$\sum_k \rho(\|\log(Z_k(s)^{-1} T_k^{-1} T_{k+1})\|^2_{\Omega_k})
+ \sum_k \rho(\|\log(\hat T_k^{-1} T_k)\|^2_{H_k})
+ \sum_k \|\mathrm{level}(T_k)\|^2_{\Lambda} + \|\mathrm{prior}(T_1, s)\|^2$$

with Cauchy's kernel ρ. Poses that leave the window are marginalised into the prior by the Schur
complement (Sibley, Matthies and Sukhatme, "Sliding window filter with application to planetary
landing", Journal of Field Robotics 2010).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices
from circumspect.motion import PoseWithCovariance, RelativeMotion

LAG = 15
"""Poses in the window."""
MAX_ITERATIONS, CONVERGED = 5, 2e-4
"""Gauss-Newton steps at most, and the step [rad, m] below which the estimate has converged."""
SCALE_DRIFT = 0.01
"""Standard deviation of the odometry scale's random walk after 1 m and after 1 rad."""
KERNEL = 6.0
"""c of Cauchy's kernel, in units of the normalised error; six degrees of freedom make √6."""

Stack = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class PoseFactor:
    """A measured pose.

    Attributes:
        T_map_camera: (4, 4) the pose.
        information: (6, 6) inverse covariance of changes after it [rad, m]; zero in directions
            that were not measured.
    """

    T_map_camera: Stack
    information: Stack


UNMEASURED = PoseFactor(np.eye(4), np.zeros((6, 6)))
"""The factor of a pose that no scan measured."""


@dataclass(frozen=True, eq=False)
class LevelFactor:
    """A robot that stands level at z = 0.

    Attributes:
        T_base_camera: (4, 4) mount of its camera.
        information: (3, 3) inverse covariance of roll [rad], pitch [rad] and height [m].
    """

    T_base_camera: Stack
    information: Stack


@dataclass(frozen=True, eq=False)
class WindowPrior:
    """What all measurements before the window say about its first pose and about the scale.

    Attributes:
        T_map_camera: (4, 4) the pose.
        scale: (2,) of the distance and of the rotation.
        information: (8, 8) inverse covariance of both.
    """

    T_map_camera: Stack
    scale: Stack
    information: Stack


@dataclass(frozen=True, eq=False)
class Window:
    """The variables and factors of the smoother.

    Attributes:
        poses: (n, 4, 4) `T_map_camera`.
        scale: (2,) of the odometry: of the distance and of the rotation.
        prior: On the first pose and on the scale.
        motions: n - 1 between consecutive poses.
        measured: n pose factors.
        level: n level factors, None where the mount is unknown.
    """

    poses: Stack
    scale: Stack
    prior: WindowPrior
    motions: tuple[RelativeMotion, ...] = ()
    measured: tuple[PoseFactor, ...] = (UNMEASURED,)
    level: tuple[LevelFactor | None, ...] = (None,)

    def linearised(self) -> tuple[Stack, Stack]:
        """The normal equations at the current estimate.

        Returns:
            (6 n + 2, 6 n + 2) Hessian and (6 n + 2,) gradient of half the cost; the last two rows
            belong to the scale.
        """
        equations = _NormalEquations.zero(len(self.poses))
        self._add_prior(equations)
        self._add_measured(equations)
        self._add_level(equations)
        if self.motions:
            self._add_motions(equations)
        return equations.assembled()

    def _add_prior(self, to: _NormalEquations) -> None:
        prior = self.prior
        change = se3_matrices.log(se3_matrices.inverse(prior.T_map_camera) @ self.poses[0])
        error = np.concatenate([change, self.scale - prior.scale])
        J = np.eye(8)
        J[:6, :6] = se3.right_jacobian_inverse(change)
        H, gradient = J.T @ prior.information @ J, J.T @ prior.information @ error
        to.diagonal[0] += H[:6, :6]
        to.border[0] += H[:6, 6:]
        to.corner += H[6:, 6:]
        to.gradient[0] += gradient[:6]
        to.scale_gradient += gradient[6:]

    def _add_measured(self, to: _NormalEquations) -> None:
        measured = np.stack([factor.T_map_camera for factor in self.measured])
        omega = np.stack([factor.information for factor in self.measured])
        errors = se3_matrices.logs(se3_matrices.inverse(measured) @ self.poses)
        J = se3.right_jacobian_inverse(errors)
        J_omega = _transposed(J) @ _robust(omega, errors)
        to.diagonal += J_omega @ J
        to.gradient += _applied(J_omega, errors)

    def _add_level(self, to: _NormalEquations) -> None:
        known = [(k, factor) for k, factor in enumerate(self.level) if factor is not None]
        if not known:
            return
        at = np.array([k for k, _ in known])
        mounts = np.stack([factor.T_base_camera for _, factor in known])
        omega = np.stack([factor.information for _, factor in known])
        errors, J = se3.level_errors(self.poses[at], mounts)
        J_omega = _transposed(J) @ omega
        to.diagonal[at] += J_omega @ J
        to.gradient[at] += _applied(J_omega, errors)

    def _add_motions(self, to: _NormalEquations) -> None:
        by_scale = np.stack([motion.by_scale for motion in self.motions])
        motions = np.stack([motion.T_before_now for motion in self.motions])
        omega = np.linalg.inv(np.stack([motion.covariance for motion in self.motions]))
        expected = motions @ se3_matrices.exps(by_scale @ (self.scale - 1))
        between = se3_matrices.inverse(self.poses[:-1]) @ self.poses[1:]
        errors = se3_matrices.logs(se3_matrices.inverse(expected) @ between)
        omega = _robust(omega, errors)
        J2 = se3.right_jacobian_inverse(errors)
        J1 = -J2 @ se3_matrices.adjoint(se3_matrices.inverse(between))
        J3 = -se3.right_jacobian_inverse(-errors) @ by_scale
        J1_omega, J2_omega, J3_omega = (_transposed(J) @ omega for J in (J1, J2, J3))
        to.diagonal[:-1] += J1_omega @ J1
        to.diagonal[1:] += J2_omega @ J2
        to.upper += J1_omega @ J2
        to.border[:-1] += J1_omega @ J3
        to.border[1:] += J2_omega @ J3
        to.corner += (J3_omega @ J3).sum(axis=0)
        to.gradient[:-1] += _applied(J1_omega, errors)
        to.gradient[1:] += _applied(J2_omega, errors)
        to.scale_gradient += _applied(J3_omega, errors).sum(axis=0)

    def moved(self, step: Stack) -> Window:
        """The same factors at another estimate.

        Args:
            step: (6 n + 2,) changes of all poses [rad, m] and of the scale.
        """
        changes = se3_matrices.exps(step[:-2].reshape(-1, 6))
        return replace(self, poses=self.poses @ changes, scale=self.scale + step[-2:])

    def without_oldest(self) -> Window:
        """The window without its first pose, whose factors become the prior of the second."""
        first = replace(
            self,
            poses=self.poses[:2],
            motions=self.motions[:1],
            measured=(self.measured[0], UNMEASURED),
            level=(self.level[0], None),
        )
        H, gradient = first.linearised()
        gain = np.linalg.solve(H[:6, :6], H[:6, 6:]).T
        information = H[6:, 6:] - gain @ H[:6, 6:]
        information = (information + information.T) / 2
        left = gradient[6:] - gain @ gradient[:6]
        # The prior lies where its gradient vanishes; directions without information stay.
        step = -np.linalg.lstsq(information, left, rcond=None)[0]
        information = _drifted(information, self.motions[0])
        second = self.poses[1] @ se3_matrices.exp(step[:6])
        prior = WindowPrior(second, self.scale + step[6:], information)
        return Window(
            self.poses[1:], self.scale, prior, self.motions[1:], self.measured[1:], self.level[1:]
        )


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
        return cls(Window(T_map_camera[None], scale, prior), known)

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
        window = self.window
        prior = replace(window.prior, T_map_camera=T_new_old @ window.prior.T_map_camera)
        measured = tuple(
            replace(factor, T_map_camera=T_new_old @ factor.T_map_camera)
            for factor in window.measured
        )
        poses = T_new_old @ window.poses
        return replace(self, window=replace(window, poses=poses, prior=prior, measured=measured))

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
        window = self.window
        window = replace(
            window,
            poses=np.concatenate([window.poses, T_map_camera[None]]),
            motions=(*window.motions, motion),
            measured=(*window.measured, measured),
            level=(*window.level, level),
        )
        H, gradient = window.linearised()
        for _ in range(MAX_ITERATIONS):
            step = -np.linalg.solve(H, gradient)
            window = window.moved(step)
            if np.abs(step).max() < CONVERGED:
                break
            H, gradient = window.linearised()
        last = np.eye(len(H))[:, -8:]
        covariance = np.linalg.solve(H, last)[-8:]
        if len(window.poses) > LAG:
            window = window.without_oldest()
        return FixedLagSmoother(window, (covariance + covariance.T) / 2)


@dataclass(eq=False)
class _NormalEquations:
    """Block tridiagonal in the poses, with a border for the scale."""

    diagonal: Stack
    upper: Stack
    border: Stack
    corner: Stack
    gradient: Stack
    scale_gradient: Stack

    @classmethod
    def zero(cls, n: int) -> Self:
        shapes = (n, 6, 6), (n - 1, 6, 6), (n, 6, 2), (2, 2), (n, 6), (2,)
        return cls(*(np.zeros(shape) for shape in shapes))

    def assembled(self) -> tuple[Stack, Stack]:
        n = len(self.diagonal)
        size, k = 6 * n, np.arange(n)
        H = np.zeros((size + 2, size + 2))
        poses = np.zeros((n, 6, n, 6))
        poses[k, :, k] = self.diagonal
        poses[k[:-1], :, k[1:]] = self.upper
        poses[k[1:], :, k[:-1]] = _transposed(self.upper)
        H[:size, :size] = poses.reshape(size, size)
        H[:size, size:] = self.border.reshape(size, 2)
        H[size:, :size] = H[:size, size:].T
        H[size:, size:] = self.corner
        return H, np.concatenate([self.gradient.ravel(), self.scale_gradient])


def _drifted(information: Stack, motion: RelativeMotion) -> Stack:
    """The prior (8, 8) after the scale drifted for one motion: a random walk, for floors change."""
    variances = SCALE_DRIFT**2 * np.linalg.norm(motion.by_scale, axis=0) + 1e-12
    # (I⁻¹ + E Q Eᵀ)⁻¹ without I⁻¹, which need not exist.
    column = information[:, 6:]
    inner = np.diag(1 / variances) + information[6:, 6:]
    return information - column @ np.linalg.solve(inner, column.T)


def _robust(omega: Stack, errors: Stack) -> Stack:
    """Information matrices weighted by Cauchy's kernel at their errors."""
    squares = np.einsum("ni,ni->n", errors, _applied(omega, errors))
    return omega / (1 + squares / KERNEL**2)[:, None, None]


def _transposed(matrices: Stack) -> Stack:
    return np.swapaxes(matrices, -1, -2)


def _applied(matrices: Stack, vectors: Stack) -> Stack:
    """(m, a) products of (m, a, b) and (m, b)."""
    return (matrices @ vectors[..., None])[..., 0]
