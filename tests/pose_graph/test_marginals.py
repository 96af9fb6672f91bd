"""Marginal covariances of a pose graph against the dense inverse and against chance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from scipy.stats import chi2

from circumspect.geometry import se3, se3_matrices
from circumspect.pose_graph.factors import BetweenFactor
from circumspect.pose_graph.pose_graph import PoseGraph, marginal_covariances

SIGMAS = np.array([0.002, 0.003, 0.004, 0.005, 0.004, 0.003])
STEP = np.array([0.0, 0.1, 0.3, 0.4, 0.0, 0.1])
EXACT = np.zeros((6, 6))


def chain(rng: np.random.Generator, n: int, loop: bool) -> tuple[np.ndarray, PoseGraph]:
    """True poses on a helix, and the graph of noisy measurements between them."""
    true = [np.eye(4)]
    for _ in range(n - 1):
        true.append(true[-1] @ se3_matrices.exp(STEP))
    pairs = [(k, k + 1) for k in range(n - 1)] + ([(0, n - 1)] if loop else [])
    factors = tuple(
        BetweenFactor(
            a, b,
            RigidTransform.from_matrix(
                se3_matrices.inverse(true[a]) @ true[b]
                @ se3_matrices.exp(rng.normal(size=6) * SIGMAS)
            ),
            np.diag(SIGMAS**-2.0),
        )
        for a, b in pairs
    )  # fmt: skip
    poses = tuple(RigidTransform.from_matrix(T) for T in true)
    return np.stack(true), PoseGraph(poses, factors).optimised()


def test_covariances_of_a_chain_add_up() -> None:
    _, graph = chain(np.random.default_rng(0), 5, loop=False)
    found = marginal_covariances(graph, EXACT)
    expected = EXACT
    np.testing.assert_allclose(found[0], EXACT)
    for k in range(1, 5):
        first, second = (graph.poses[n].as_matrix() for n in (k - 1, k))
        Ad = se3_matrices.adjoint(se3_matrices.inverse(second) @ first)
        expected = Ad @ expected @ Ad.T + np.diag(SIGMAS**2)
        np.testing.assert_allclose(found[k], expected, rtol=0.02, atol=1e-9)


def test_a_loop_closure_makes_the_end_as_certain_as_one_step() -> None:
    _, open_chain = chain(np.random.default_rng(0), 12, loop=False)
    _, closed = chain(np.random.default_rng(0), 12, loop=True)
    loose = marginal_covariances(open_chain, EXACT)[-1]
    tight = marginal_covariances(closed, EXACT)[-1]
    assert np.trace(tight) < 0.3 * np.trace(loose)
    assert (np.diag(tight) <= SIGMAS**2 * 1.01).all()


def test_errors_are_consistent_with_the_covariances() -> None:
    squares = []
    for seed in range(60):
        true, graph = chain(np.random.default_rng(seed), 8, loop=True)
        covariances = marginal_covariances(graph, EXACT)
        for k in (3, 7):
            error = se3.log(RigidTransform.from_matrix(true[k]).inv() * graph.poses[k])
            squares.append(error @ np.linalg.solve(covariances[k], error))
    # Both poses of one graph are correlated, so that the bound is wide.
    low, high = chi2(6 * len(squares) / 2).ppf([1e-4, 1 - 1e-4]) / (len(squares) / 2)
    assert low < np.mean(squares) < high


def test_the_first_covariance_moves_with_the_poses() -> None:
    _, graph = chain(np.random.default_rng(1), 4, loop=False)
    first = np.diag([1e-4, 0, 0, 0, 0, 0])
    added = marginal_covariances(graph, first) - marginal_covariances(graph, EXACT)
    lever = np.linalg.norm(graph.poses[3].translation)
    assert np.trace(added[3][3:, 3:]) == pytest.approx(
        1e-4 * (lever**2 - graph.poses[3].translation[0] ** 2)
    )
