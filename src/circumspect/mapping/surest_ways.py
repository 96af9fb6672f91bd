"""How well keyframes are known: along the surest way from the first one to each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from graphlib import TopologicalSorter

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3, se3_matrices
from circumspect.geometry.composition import between
from circumspect.mapping.keyframe import Keyframe
from circumspect.pose_graph import BetweenFactor, GraphProblem
from circumspect.pose_graph.normal_equations import CAUCHY_SCALE

SURER = 1 - 1e-6
"""What makes a variance less than this times as large is no rounding."""


def by_surest_ways(
    keyframes: Sequence[Keyframe], edges: Sequence[BetweenFactor]
) -> dict[int, Keyframe]:
    """Keyframes with the parents that know them best, and what follows for their covariance.

    Fits of neighbours to each other are not independent, so ways are not joined: a covariance is
    the sum along a single one, over parents or edges. Ways are made surer going forth along the
    drive and back until none can be (Bellman and Ford's algorithm).

    Args:
        keyframes: All, in order; the first has no parent.
        edges: Between them by number, such that agree with the poses.

    Returns:
        All, by number.
    """
    keys = _by_parents({key.number: key for key in keyframes})
    links = [
        (key.parent, key.number, key.since_parent) for key in keyframes if key.parent is not None
    ]
    links += [(edge.first, edge.second, np.linalg.inv(edge.information)) for edge in edges]
    if not links:
        return keys
    links.sort(key=lambda link: max(link[:2]))
    poses = _matrices(keys)
    forth = se3_matrices.adjoint(_between(poses, [(second, first) for first, second, _ in links]))
    back = se3_matrices.adjoint(_between(poses, [link[:2] for link in links]))
    ways = [(one, other, step, Ad) for (one, other, step), Ad in zip(links, forth, strict=True)]
    ways += [
        (other, one, Ad @ step @ Ad.T, Ad)
        for (one, other, step), Ad in zip(links[::-1], back[::-1], strict=True)
    ]
    surer = True
    while surer:
        surer = max([_follow(keys, *way) for way in ways])
    return keys


def _by_parents(keys: dict[int, Keyframe]) -> dict[int, Keyframe]:
    """With the covariances that follow from their parents', as all lie now."""
    order = TopologicalSorter(
        {number: () if key.parent is None else (key.parent,) for number, key in keys.items()}
    )
    links = [(number, key.parent) for number, key in keys.items() if key.parent is not None]
    if not links:
        return keys
    moves = se3_matrices.adjoint(_between(_matrices(keys), links))
    Ad = {number: move for (number, _), move in zip(links, moves, strict=True)}
    for number in order.static_order():
        key = keys[number]
        if key.parent is not None:
            known = Ad[number] @ keys[key.parent].covariance @ Ad[number].T + key.since_parent
            keys[number] = replace(key, covariance=known)
    return keys


def moved_covariance(one: Keyframe, other: Keyframe) -> NDArray[np.floating]:
    """(6, 6) of one keyframe's pose, told of the other as if that were fixed to it."""
    T_other_one = between(other.T_map_camera, one.T_map_camera)
    return se3.moved_covariance(T_other_one, one.covariance)


def _matrices(keys: Mapping[int, Keyframe]) -> dict[int, NDArray[np.float64]]:
    return {number: key.T_map_camera.as_matrix() for number, key in keys.items()}


def _between(
    poses: Mapping[int, NDArray[np.float64]], pairs: Sequence[tuple[int, int]]
) -> NDArray[np.float64]:
    """(n, 4, 4) `T_one_other` of each pair of numbers."""
    ones = np.stack([poses[one] for one, _ in pairs])
    return se3_matrices.inverse(ones) @ np.stack([poses[other] for _, other in pairs])


def _follow(
    keys: dict[int, Keyframe],
    here: int,
    there: int,
    step: NDArray[np.floating],
    Ad: NDArray[np.floating],
) -> bool:
    """Take a way if it is surer than what is known."""
    found = Ad @ keys[here].covariance @ Ad.T + step
    if _place(found) >= SURER * _place(keys[there].covariance):
        return False
    keys[there] = replace(keys[there], covariance=found, parent=here, since_parent=step)
    return True


def _place(covariance: NDArray[np.floating]) -> float:
    """[m²] the variance of a place."""
    return float(covariance[3, 3] + covariance[4, 4] + covariance[5, 5])


def agreeing(edges: Sequence[BetweenFactor], keys: Mapping[int, Keyframe]) -> list[BetweenFactor]:
    """Those that have it as the poses have it, as far as their kernel takes them for sound."""
    numbers = {number for edge in edges for number in (edge.first, edge.second)}
    place = {number: index for index, number in enumerate(numbers)}
    if not place:
        return []
    poses = np.stack([keys[number].T_map_camera.as_matrix() for number in numbers])
    placed = [replace(e, first=place[e.first], second=place[e.second]) for e in edges]
    squares = GraphProblem.from_factors(placed, ()).at(poses).squared_errors
    return [edge for edge, square in zip(edges, squares, strict=True) if square < CAUCHY_SCALE**2]


def share_of_variance(edge: BetweenFactor, first: Keyframe, second: Keyframe) -> float:
    """How the variance of the second one's place would change if it were known by the edge."""
    found = moved_covariance(first, second) + np.linalg.inv(edge.information)
    return _place(found) / _place(second.covariance)
