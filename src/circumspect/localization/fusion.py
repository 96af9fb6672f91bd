"""Fusion of the poses seen by several cameras, and sets of cameras that agree."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose, wrapped
from circumspect.localization.tag_pose import TagPose

MAX_COMPARED = 12
"""Maximum number of compared cameras; those with the smallest covariances are chosen."""


def difference(pose: PlanarPose, other: PlanarPose) -> NDArray[np.float64]:
    """Difference of two poses: (3,) x, y [m] and yaw [rad], wrapped."""
    turn = wrapped(pose.yaw - other.yaw)
    return np.array([pose.x - other.x, pose.y - other.y, turn])


def distance2(pose: PlanarPose, other: PlanarPose, covariance: NDArray[np.float64]) -> float:
    """Squared Mahalanobis distance; `covariance` (3, 3) is that of the difference."""
    apart = difference(pose, other)
    return float(apart @ np.linalg.solve(covariance, apart))


def fused(poses: Sequence[TagPose]) -> TagPose:
    """Information-weighted mean of independent measurements.

    With total covariances Cᵢ and C = (Σ Cᵢ⁻¹)⁻¹, the weights are Wᵢ = C Cᵢ⁻¹. Noise and bias are
    propagated separately. The squared residual is the sum of the squared distances from the mean.

    Args:
        poses: At least one, in any order.

    Raises:
        InputError: There is no pose.
    """
    if not poses:
        raise InputError("there is no pose to fuse")
    middle = poses[0].T_map_base
    apart = np.array([difference(pose.T_map_base, middle) for pose in poses])
    information = np.array([np.linalg.inv(pose.covariance) for pose in poses])
    whole = np.linalg.inv(information.sum(axis=0))
    shift = whole @ np.einsum("nij,nj->i", information, apart)
    weights = whole @ information
    noise = _through(weights, np.array([pose.noise for pose in poses]))
    bias = _through(weights, np.array([pose.bias for pose in poses]))
    off = apart - shift
    squared_residual = float(np.einsum("ni,nij,nj->", off, information, off))
    at = PlanarPose(*(np.array([middle.x, middle.y, middle.yaw]) + shift))
    return TagPose(at, _symmetric(noise), _symmetric(bias), squared_residual)


def agreeing(poses: Sequence[TagPose], max_squared_distance: float) -> list[tuple[int, ...]]:
    """The largest sets of poses that agree pairwise.

    Args:
        poses: Poses from different cameras.
        max_squared_distance: Maximum squared Mahalanobis distance of poses that agree.

    Returns:
        Sets of indices; several if there are equally large sets without a common camera.
    """
    some = sorted(range(len(poses)), key=lambda i: float(np.trace(poses[i].covariance)))
    some = sorted(some[:MAX_COMPARED])
    agree = {
        (i, j): distance2(
            poses[i].T_map_base,
            poses[j].T_map_base,
            poses[i].covariance + poses[j].covariance,
        )
        <= max_squared_distance
        for i, j in combinations(some, 2)
    }
    for size in range(len(some), 0, -1):
        found = [
            chosen
            for chosen in combinations(some, size)
            if all(agree[pair] for pair in combinations(chosen, 2))
        ]
        if found and set.intersection(*map(set, found)):
            # The sets have a common camera and differ only at the bound: the best one is used.
            return [
                min(found, key=lambda chosen: fused([poses[i] for i in chosen]).squared_residual)
            ]
        if found:
            return found
    return []


def _through(weights: NDArray[np.float64], covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Σ Wᵢ Cᵢ Wᵢᵀ."""
    return np.einsum("nij,njk,nlk->il", weights, covariances, weights)


def _symmetric(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return (matrix + matrix.T) / 2
