"""Optimisation of pose graphs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.pose_graph import BetweenFactor, LevelFactor, PoseGraph

SIGMAS = np.array([0.01] * 3 + [0.02] * 3)
OMEGA = np.diag(SIGMAS**-2)


def ring(count: int) -> list[RigidTransform]:
    angles = np.arange(count) * 2 * np.pi / count
    steps = [[0, 0, a, 0, 0, 0] for a in angles]
    return [
        RigidTransform.from_translation([np.cos(a), np.sin(a), 0.1 * np.sin(2 * a)]) * se3.exp(s)
        for a, s in zip(angles, steps, strict=True)
    ]


def loop(
    count: int, noise: float, seed: int = 0
) -> tuple[list[RigidTransform], list[BetweenFactor]]:
    """True poses on a ring, and measurements between neighbours and one that closes the loop."""
    rng, true = np.random.default_rng(seed), ring(count)
    factors = []
    for i in range(count):
        j = (i + 1) % count
        drawn = se3.exp(noise * SIGMAS * rng.normal(size=6))
        factors.append(BetweenFactor(i, j, true[i].inv() * true[j] * drawn, OMEGA))
    return true, factors


def chained(first: RigidTransform, factors: list[BetweenFactor]) -> tuple[RigidTransform, ...]:
    poses = [first]
    for factor in factors[:-1]:
        poses.append(poses[-1] * factor.T_first_second)
    return tuple(poses)


def apart(one: RigidTransform, other: RigidTransform) -> float:
    return float(np.abs(se3.log(one.inv() * other)).max())


def test_exact_measurements_recover_the_true_poses() -> None:
    true, factors = loop(12, noise=0.0)
    rng = np.random.default_rng(1)
    off = [true[0], *(T * se3.exp(rng.normal(0, 0.1, 6)) for T in true[1:])]
    found = PoseGraph(tuple(off), tuple(factors)).optimised()
    assert found.cost < 1e-9
    assert max(apart(a, b) for a, b in zip(found.poses, true, strict=True)) < 1e-6


@pytest.mark.parametrize("seed", [0, 1])
def test_optimum_equals_that_of_dense_least_squares(seed: int) -> None:
    true, factors = loop(6, noise=3.0, seed=seed)
    graph = PoseGraph(chained(true[0], factors), tuple(factors))
    found = graph.optimised()

    def residuals(changes: np.ndarray) -> np.ndarray:
        moved = [
            T * se3.exp(c) for T, c in zip(graph.poses[1:], changes.reshape(-1, 6), strict=True)
        ]
        poses = [graph.poses[0], *moved]
        errors = [
            se3.log(e.T_first_second.inv() * poses[e.first].inv() * poses[e.second])
            for e in factors
        ]
        return np.concatenate([error / SIGMAS for error in errors])

    dense = least_squares(residuals, np.zeros(30), xtol=1e-12, ftol=1e-14, gtol=1e-12)
    assert found.cost == pytest.approx(2 * dense.cost, rel=1e-5)
    moved = [T * se3.exp(c) for T, c in zip(graph.poses[1:], dense.x.reshape(-1, 6), strict=True)]
    assert max(apart(a, b) for a, b in zip(found.poses[1:], moved, strict=True)) < 1e-4
    assert found.cost < graph.cost / 2


def test_first_pose_is_fixed_and_a_common_motion_moves_all() -> None:
    true, factors = loop(8, noise=2.0)
    graph = PoseGraph(chained(true[0], factors), tuple(factors))
    G = se3.exp([0.4, -0.3, 1.0, 2.0, -1.0, 0.5])
    found = graph.optimised()
    moved = PoseGraph(tuple(G * T for T in graph.poses), tuple(factors)).optimised()
    assert apart(found.poses[0], graph.poses[0]) == 0
    assert max(apart(G * a, b) for a, b in zip(found.poses, moved.poses, strict=True)) < 1e-6


def test_robust_outlier_has_little_influence() -> None:
    true, factors = loop(10, noise=0.3)
    wrong = BetweenFactor(0, 5, se3.exp([0, 0, 1.0, 1.0, 0, 0]), OMEGA, robust=True)
    poses = chained(true[0], factors)
    with_it = PoseGraph(poses, (*factors, wrong)).optimised()
    without = PoseGraph(poses, tuple(factors)).optimised()
    believed = BetweenFactor(0, 5, wrong.T_first_second, OMEGA)
    bent = PoseGraph(poses, (*factors, believed)).optimised()
    little = max(apart(a, b) for a, b in zip(with_it.poses, without.poses, strict=True))
    much = max(apart(a, b) for a, b in zip(bent.poses, without.poses, strict=True))
    assert little < 0.02 < 0.2 < much


def test_level_factors_limit_the_drift_in_height() -> None:
    mount = se3.exp([0.3, 0.0, 0.0, 0.0, 0.1, 1.0])
    rise = se3.exp([0.0, 0.002, 0.0, 0.1, 0.0, 0.004])
    bases = [RigidTransform.identity()]
    for _ in range(9):
        bases.append(bases[-1] * rise)
    poses = tuple(T * mount for T in bases)
    factors = tuple(BetweenFactor(i, i + 1, poses[i].inv() * poses[i + 1], OMEGA) for i in range(9))
    levels = tuple(LevelFactor(i, mount, np.diag([1e4, 1e4, 1e6])) for i in range(10))
    before = [abs((T * mount.inv()).translation[2]) for T in poses]
    after = [
        abs((T * mount.inv()).translation[2])
        for T in PoseGraph(poses, factors, levels).optimised().poses
    ]
    assert max(after) < 0.2 * max(before)


def test_graph_without_factors_is_returned_unchanged() -> None:
    graph = PoseGraph(tuple(ring(3)))
    assert graph.optimised() is graph


def test_poses_without_factors_stay() -> None:
    poses = tuple(ring(4))
    factor = BetweenFactor(
        0, 1, poses[0].inv() * poses[1] * se3.exp([0, 0, 0.01, 0.05, 0, 0]), OMEGA
    )
    found = PoseGraph(poses, (factor,)).optimised()
    assert apart(found.poses[3], poses[3]) < 1e-9
    assert apart(found.poses[1], poses[1]) > 0.04
