"""Covariances of single poses of a pose graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.pose_graph.pose_graph import PoseGraph


def marginal_covariances(
    graph: PoseGraph, first_covariance: NDArray[np.floating]
) -> NDArray[np.floating]:
    """Marginal covariances of all poses at the current estimate.

    They are the diagonal blocks of the inverse Hessian (Kaess and Dellaert, "Covariance recovery
    from a square root information matrix for data association", 2009) with robust weights. The
    graph fixes its first pose; that one's covariance is added to all others.

    Args:
        graph: At its optimum. Poses without a path of factors to the first one have no finite
            covariance.
        first_covariance: (6, 6) of the first pose [rad, m].

    Returns:
        (n, 6, 6) [rad, m], in the frame of each pose.
    """
    n = len(graph.poses)
    covariances = np.zeros((n, 6, 6))
    if n > 1:
        # The inverse is dense, and dense algebra is the quickest way to it.
        inverse = np.linalg.inv(graph.hessian[6:, 6:].toarray()).reshape(n - 1, 6, n - 1, 6)
        k = np.arange(n - 1)
        covariances[1:] = inverse[k, :, k]
    poses = np.stack([pose.as_matrix() for pose in graph.poses])
    Ad = se3_matrices.adjoint(se3_matrices.inverse(poses) @ poses[0])
    covariances += Ad @ first_covariance @ np.swapaxes(Ad, -1, -2)
    return (covariances + np.swapaxes(covariances, -1, -2)) / 2
