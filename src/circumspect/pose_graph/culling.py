"""Between factors of a graph of bounded size: transfer from culled poses, and pruning."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.geometry.composition import composed
from circumspect.pose_graph.factors import BetweenFactor


def transfer_factors(
    factors: list[BetweenFactor],
    culled: int,
    substitute: int,
    T_substitute_culled: RigidTransform,
) -> list[BetweenFactor]:
    """The factors after a pose is culled.

    Factors of the culled pose are transferred to the substitute and become robust. Those between
    the two are dropped.

    Args:
        factors: All factors.
        culled: Index of the culled pose.
        substitute: Index of the pose that takes over its factors.
        T_substitute_culled: Pose of the culled one in the frame of the substitute.
    """
    kept = []
    for factor in factors:
        if culled not in (factor.first, factor.second):
            kept.append(factor)
        elif substitute in (factor.first, factor.second):
            continue
        elif factor.first == culled:
            moved = replace(
                factor,
                robust=True,
                transferred=True,
                first=substitute,
                T_first_second=composed(T_substitute_culled, factor.T_first_second),
            )
            kept.append(moved)
        else:
            moved = replace(
                factor,
                robust=True,
                transferred=True,
                second=substitute,
                T_first_second=composed(factor.T_first_second, T_substitute_culled.inv()),
                information=se3.moved_information(T_substitute_culled, factor.information),
            )
            kept.append(moved)
    return kept


def prune_factors(factors: list[BetweenFactor], max_factors: int) -> list[BetweenFactor]:
    """At most one factor per pair of poses, and at most `max_factors` in total.

    The strongest factor of each pair is kept. If there are too many, factors between the poses with
    the most factors are removed first. Factors that are not robust (the odometry chain) and those
    that alone connect two parts of the graph are never removed, even if more than `max_factors`
    remain.
    """
    strongest: dict[tuple[int, int], BetweenFactor] = {}
    for factor in factors:
        pair = (min(factor.first, factor.second), max(factor.first, factor.second))
        known = strongest.get(pair)
        if known is None or _strength(factor) > _strength(known):
            strongest[pair] = factor
    kept = list(strongest.values())
    required = _spanning_forest(kept) if len(kept) > max_factors else set()
    while len(kept) > max_factors:
        degrees = Counter(pose for factor in kept for pose in (factor.first, factor.second))
        removable = [
            index for index, factor in enumerate(kept) if factor.robust and factor not in required
        ]
        if not removable:
            break
        density = [
            min(degrees[kept[index].first], degrees[kept[index].second]) for index in removable
        ]
        del kept[removable[int(np.argmax(density))]]
    return kept


def _spanning_forest(factors: list[BetweenFactor]) -> set[BetweenFactor]:
    """The strongest factors that connect all connected poses, by Kruskal's algorithm."""
    part = {pose: pose for factor in factors for pose in (factor.first, factor.second)}
    chosen = set()
    for factor in sorted(factors, key=_strength, reverse=True):
        one, other = part[factor.first], part[factor.second]
        if one != other:
            chosen.add(factor)
            part = {pose: one if root == other else root for pose, root in part.items()}
    return chosen


def _strength(factor: BetweenFactor) -> tuple[bool, float]:
    return not factor.robust, float(np.trace(factor.information))
