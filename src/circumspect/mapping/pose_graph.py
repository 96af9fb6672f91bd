"""Poses that agree best with many relative measurements."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3
from circumspect.geometry.composition import composed, orthonormal
from circumspect.mapping.graph_problem import GraphProblem, GraphState

ROUNDS = 30
SMALL = 1e-7
"""Converged once no pose changes by more than this [rad], [m]."""


@dataclass(frozen=True, eq=False)
class Edge:
    """A measurement of one pose seen from another.

    Attributes:
        first, second: Which poses.
        T_first_second: What was measured.
        information: (6, 6) inverse covariance of changes after it.
        robust: A measurement that may be plain wrong; it is weighted by Cauchy's kernel.
        inherited: It was measured at a pose that one of these stands for now.
    """

    first: int
    second: int
    T_first_second: RigidTransform
    information: NDArray[np.floating]
    robust: bool = False
    inherited: bool = False


@dataclass(frozen=True, eq=False)
class Level:
    """A robot that stands level at z = 0, up to bumps.

    Attributes:
        number: Which pose.
        T_base_camera: The camera's mount.
        information: (3, 3) inverse covariance of roll [rad], pitch [rad] and height [m].
    """

    number: int
    T_base_camera: RigidTransform
    information: NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """Poses T_map_camera and what was measured between them; the first pose stays.

    Attributes:
        poses: At least one.
        edges: Between them.
        levels: On single ones.
    """

    poses: tuple[RigidTransform, ...]
    edges: tuple[Edge, ...] = ()
    levels: tuple[Level, ...] = ()

    @property
    def cost(self) -> float:
        """Σ ρ(eᵀ Ω e) over the edges and Σ eᵀ Ω e over the levels."""
        return self._state.cost

    def optimised(self) -> PoseGraph:
        """The poses of least cost near these, by Gauss-Newton.

        The error of an edge is e = log(Z⁻¹ T₁⁻¹ T₂) with Z the measurement (Grisetti et al., "A
        tutorial on graph-based SLAM", 2010); steps that raise the cost are damped after
        Levenberg and Marquardt. Poses that no measurement reaches stay.
        """
        if len(self.poses) < 2 or not self.edges:
            return self
        here, damping = self._state, 1e-9
        cost = here.cost
        for _ in range(ROUNDS):
            step = here.step(damping)
            there = here.moved(step)
            lower = there.cost
            if not lower <= cost * (1 + 1e-12) + 1e-15:  # nor where it is no number
                damping = max(1e-6, 10 * damping)
                if damping > 1e6:
                    break
                continue
            here, cost, damping = there, lower, max(damping / 10, 1e-9)
            if np.abs(step).max() < SMALL:
                break
        return replace(self, poses=tuple(map(orthonormal, here.poses)))

    @property
    def _state(self) -> GraphState:
        poses = np.stack([pose.as_matrix() for pose in self.poses])
        return GraphProblem.of(self.edges, self.levels).at(poses)


def bridged(edges: list[Edge], gone: int, heir: int, T_heir_gone: RigidTransform) -> list[Edge]:
    """The edges after a pose was taken out: those at it are hung on its heir."""
    kept = []
    for edge in edges:
        if gone not in (edge.first, edge.second):
            kept.append(edge)
        elif heir in (edge.first, edge.second):
            continue
        elif edge.first == gone:
            measured = composed(T_heir_gone, edge.T_first_second)
            kept.append(
                Edge(heir, edge.second, measured, edge.information, robust=True, inherited=True)
            )
        else:
            measured = composed(edge.T_first_second, T_heir_gone.inv())
            information = se3.moved_information(T_heir_gone, edge.information)
            kept.append(Edge(edge.first, heir, measured, information, robust=True, inherited=True))
    return kept


def thinned(edges: list[Edge], most: int) -> list[Edge]:
    """At most one edge a pair of poses, the firmest, and no more than `most` in all.

    Bridging hangs edges of one pose after another on the same heirs. Of too many, those between
    the poses with the most edges go first. What is not robust, the chain of the drive, stays, and
    what alone holds two parts together.
    """
    best: dict[tuple[int, int], Edge] = {}
    for edge in edges:
        pair = (min(edge.first, edge.second), max(edge.first, edge.second))
        known = best.get(pair)
        if known is None or _firmness(edge) > _firmness(known):
            best[pair] = edge
    kept = list(best.values())
    holding = _spanning(kept) if len(kept) > most else set()
    while len(kept) > most:
        ends = Counter(number for edge in kept for number in (edge.first, edge.second))
        loose = [n for n, edge in enumerate(kept) if edge.robust and edge not in holding]
        if not loose:
            break
        crowd = [min(ends[kept[index].first], ends[kept[index].second]) for index in loose]
        del kept[loose[int(np.argmax(crowd))]]
    return kept


def _spanning(edges: list[Edge]) -> set[Edge]:
    """The firmest edges that hold together all that is connected: a spanning forest, by Kruskal."""
    part = {number: number for edge in edges for number in (edge.first, edge.second)}
    chosen = set()
    for edge in sorted(edges, key=_firmness, reverse=True):
        one, other = part[edge.first], part[edge.second]
        if one != other:
            chosen.add(edge)
            part = {number: one if at == other else at for number, at in part.items()}
    return chosen


def _firmness(edge: Edge) -> tuple[bool, float]:
    return not edge.robust, float(np.trace(edge.information))
