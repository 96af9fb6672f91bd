"""Transfer of factors from culled poses, and pruning."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.pose_graph import BetweenFactor, prune_factors, transfer_factors

I6 = np.eye(6)
T = RigidTransform.identity()


def parts(factors: Iterable[BetweenFactor], poses: Iterable[int]) -> int:
    """Number of connected parts of a graph."""
    index = {pose: row for row, pose in enumerate(poses)}
    pairs = np.array([[index[f.first], index[f.second]] for f in factors])
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(index), len(index)))
    return connected_components(links, directed=False)[0]


@pytest.mark.parametrize("seed", range(3))
def test_transferred_factors_agree_with_the_same_poses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = [se3.exp(rng.normal(0, 0.5, 6)) for _ in range(4)]
    pairs = [(0, 1), (1, 2), (1, 3), (0, 2), (3, 1)]
    factors = [BetweenFactor(a, b, poses[a].inv() * poses[b], I6) for a, b in pairs]
    kept = transfer_factors(factors, 1, 0, poses[0].inv() * poses[1])
    assert [(f.first, f.second) for f in kept] == [(0, 2), (0, 3), (0, 2), (3, 0)]
    assert [f.transferred for f in kept] == [True, True, False, True]
    assert [f.robust for f in kept] == [True, True, False, True]
    for factor in kept:
        expected = poses[factor.first].inv() * poses[factor.second]
        error = se3.log(expected.inv() * factor.T_first_second)
        np.testing.assert_allclose(error, 0, atol=1e-12)


def test_strongest_factor_of_a_pair_is_kept() -> None:
    weak = BetweenFactor(0, 1, T, I6, robust=True)
    strong = BetweenFactor(1, 0, T, 9 * I6, robust=True)
    chain = BetweenFactor(1, 2, T, I6)
    loop = BetweenFactor(2, 1, T, 99 * I6, robust=True)
    assert prune_factors([weak, strong, chain, loop], 10) == [strong, chain]


@pytest.mark.parametrize("max_factors", [12, 20])
def test_dense_factors_are_pruned_and_the_chain_is_kept(max_factors: int) -> None:
    chain = [BetweenFactor(n, n + 1, T, I6) for n in range(9)]
    dense = [BetweenFactor(a, b, T, I6, robust=True) for a in range(6) for b in range(a + 2, 6)]
    sparse = BetweenFactor(7, 9, T, I6, robust=True)
    kept = prune_factors([*chain, *dense, sparse], max_factors)
    assert len(kept) == max_factors
    assert set(chain) <= set(kept)
    assert sparse in kept


def test_factor_that_alone_connects_two_parts_is_kept() -> None:
    bridge = BetweenFactor(0, 10, T, I6, robust=True)
    dense = [
        BetweenFactor(a, b, T, 9 * I6, robust=True)
        for first in (0, 10)
        for a in range(first, first + 6)
        for b in range(a + 1, first + 6)
    ]
    kept = prune_factors([bridge, *dense], 11)
    assert len(kept) == 11
    assert parts(kept, [*range(6), *range(10, 16)]) == 1
