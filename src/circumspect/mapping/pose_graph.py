"""Poses that agree best with many relative measurements."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.composition import composed
from circumspect.mapping import se3

KERNEL = 6.0
"""c of Cauchy's kernel, in units of the normalised error; six degrees of freedom make √6."""
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
        squares = self._edge_errors()[1]
        robust = np.array([edge.robust for edge in self.edges])
        total = float(np.where(robust, KERNEL**2 * np.log1p(squares / KERNEL**2), squares).sum())
        if self.levels:
            errors, _, omega = self._level_errors()
            total += float(np.einsum("mi,mij,mj->", errors, omega, errors))
        return total

    def optimised(self) -> PoseGraph:
        """The poses of least cost near these, by Gauss-Newton.

        The error of an edge is e = log(Z⁻¹ T₁⁻¹ T₂) with Z the measurement (Grisetti et al., "A
        tutorial on graph-based SLAM", 2010); steps that raise the cost are damped after
        Levenberg and Marquardt. Poses that no measurement reaches stay.
        """
        if len(self.poses) < 2 or not self.edges:
            return self
        graph, damping = self, 1e-9
        cost = graph.cost
        for _ in range(ROUNDS):
            step = graph._step(damping)
            moved = graph._moved(step)
            lower = moved.cost
            if lower > cost * (1 + 1e-12) + 1e-15:
                damping = max(1e-6, 10 * damping)
                if damping > 1e6:
                    break
                continue
            graph, cost, damping = moved, lower, max(damping / 10, 1e-9)
            if np.abs(step).max() < SMALL:
                break
        return graph

    def _moved(self, step: NDArray[np.float64]) -> PoseGraph:
        batch = RigidTransform.concatenate(list(self.poses)) * se3.exp(step.reshape(-1, 6))
        return replace(self, poses=tuple(batch[number] for number in range(len(self.poses))))

    def _edge_errors(
        self,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], RigidTransform]:
        """(m, 6) errors, (m,) squared normalised errors, and T₁⁻¹T₂ of the edges."""
        poses = RigidTransform.concatenate(list(self.poses))
        first = poses[np.array([edge.first for edge in self.edges])]
        second = poses[np.array([edge.second for edge in self.edges])]
        measured = RigidTransform.concatenate([edge.T_first_second for edge in self.edges])
        between = first.inv() * second
        errors = se3.log(measured.inv() * between)
        squares = np.einsum("mi,mij,mj->m", errors, self._informations(), errors)
        return errors, squares, between

    def _informations(self) -> NDArray[np.floating]:
        return np.stack([edge.information for edge in self.edges])

    def _level_errors(
        self,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.floating]]:
        """(m, 3) errors, (m, 3, 6) derivatives and (m, 3, 3) information of the levels."""
        poses = RigidTransform.concatenate([self.poses[level.number] for level in self.levels])
        mounts = RigidTransform.concatenate([level.T_base_camera for level in self.levels])
        return (
            *se3.level_error(poses, mounts),
            np.stack([level.information for level in self.levels]),
        )

    def _step(self, damping: float) -> NDArray[np.float64]:
        """(6 n,) the Gauss-Newton step; zero for the first pose."""
        from scipy.sparse import coo_array, csc_array, diags_array
        from scipy.sparse.linalg import spsolve

        blocks, rows, columns, gradient = self._normal_equations()
        size = 6 * len(self.poses)
        cell = np.arange(6)
        i = np.broadcast_to(6 * rows[:, None, None] + cell[:, None], blocks.shape)
        j = np.broadcast_to(6 * columns[:, None, None] + cell[None, :], blocks.shape)
        H = coo_array((blocks.ravel(), (i.ravel(), j.ravel())), shape=(size, size))
        # Poses that nothing holds stay where they are.
        H = csc_array(H + diags_array(damping * H.diagonal() + 1e-9))
        step = np.zeros(size)
        step[6:] = -spsolve(H[6:, 6:], gradient[6:])
        return step

    def _normal_equations(
        self,
    ) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
        errors, squares, between = self._edge_errors()
        robust = np.array([edge.robust for edge in self.edges])
        weights = np.where(robust, 1 / (1 + squares / KERNEL**2), 1.0)
        omega = self._informations() * weights[:, None, None]
        J2 = se3.right_jacobian_inverse(errors)
        J1 = -J2 @ se3.adjoint(between.inv())
        first = np.array([edge.first for edge in self.edges])
        second = np.array([edge.second for edge in self.edges])
        gradient = np.zeros(6 * len(self.poses))
        blocks, rows, columns = [], [], []
        for Ja, a in ((J1, first), (J2, second)):
            pull = np.einsum("mki,mkl,ml->mi", Ja, omega, errors)
            np.add.at(gradient.reshape(-1, 6), a, pull)
            for Jb, b in ((J1, first), (J2, second)):
                blocks.append(np.einsum("mki,mkl,mlj->mij", Ja, omega, Jb))
                rows.append(a)
                columns.append(b)
        if self.levels:
            errors, J, omega = self._level_errors()
            numbers = np.array([level.number for level in self.levels])
            blocks.append(np.einsum("mki,mkl,mlj->mij", J, omega, J))
            rows.append(numbers)
            columns.append(numbers)
            pull = np.einsum("mki,mkl,ml->mi", J, omega, errors)
            np.add.at(gradient.reshape(-1, 6), numbers, pull)
        return np.concatenate(blocks), np.concatenate(rows), np.concatenate(columns), gradient


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
