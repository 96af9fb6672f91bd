"""Keyframes and the factors between them: lookup, optimisation, marginals and culling."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.composition import distances, orthonormal
from circumspect.pose_graph.culling import prune_factors, transfer_factors
from circumspect.pose_graph.factors import BetweenFactor, LevelFactor
from circumspect.pose_graph.keyframe import Keyframe
from circumspect.pose_graph.pose_graph import PoseGraph, marginal_covariances

MAX_FACTORS_PER_KEYFRAME = 8
MAX_CULLED = 4096
"""Maximum number of culled keyframes that are remembered; the oldest are forgotten first."""


class CulledKeyframes:
    """Poses of culled keyframes relative to their substitutes."""

    def __init__(self, max_culled: int = MAX_CULLED) -> None:
        """Start empty.

        Args:
            max_culled: Maximum number that is remembered.
        """
        self._max = max_culled
        self._substitutes: dict[int, tuple[int, NDArray[np.floating]]] = {}

    def __len__(self) -> int:
        return len(self._substitutes)

    def add(self, culled: int, substitute: int, T_substitute_culled: NDArray[np.floating]) -> None:
        """Record a culled keyframe.

        Args:
            culled: Number of the culled keyframe.
            substitute: Number of its substitute.
            T_substitute_culled: (4, 4) pose of the culled keyframe relative to the substitute.
        """
        self._substitutes[culled] = (substitute, T_substitute_culled)
        if len(self._substitutes) > self._max:
            del self._substitutes[next(iter(self._substitutes))]

    def substitute(
        self, number: int, T_number_x: NDArray[np.floating]
    ) -> tuple[int, NDArray[np.floating]]:
        """The keyframe that represents a possibly culled one, and a pose relative to it.

        Args:
            number: Number of a keyframe, which may have been culled.
            T_number_x: (4, 4) a pose relative to that keyframe.

        Returns:
            The number of a keyframe that exists or was forgotten, and `T_substitute_x`.
        """
        while number in self._substitutes:
            number, T_substitute_number = self._substitutes[number]
            T_number_x = T_substitute_number @ T_number_x
        return number, T_number_x


@dataclass(frozen=True)
class KeyframeSettings:
    """Selection and correction of keyframes.

    Attributes:
        max_baseline: A frame becomes a keyframe if it is farther than this from its reference
            keyframe, as a fraction of its median depth …
        max_rotation: … or rotated by more than this [rad], …
        min_overlap: … or if a smaller fraction of its points lies on the map and it has reached the
            fraction `min_step` of the other bounds.
        max_keyframes: Maximum number; beyond it the keyframe nearest to another is culled.
        min_correction, min_correction_rotation: Smaller corrections [m], [rad] are applied when the
            tracker is finalised.
    """

    max_baseline: float = 0.2
    max_rotation: float = float(np.radians(12.0))
    min_overlap: float = 0.85
    min_step: float = 0.25
    max_keyframes: int = 240
    min_correction: float = 0.004
    min_correction_rotation: float = float(np.radians(0.3))


class KeyframeGraph:
    """Keyframes by their number, in the order in which they were added."""

    def __init__(self, level_covariance: NDArray[np.floating], settings: KeyframeSettings) -> None:
        """Start empty.

        Args:
            level_covariance: (3, 3) of roll [rad], pitch [rad] and height [m] of the base.
            settings: Distances and maximum number of keyframes.
        """
        self.settings = settings
        self.poses: NDArray[np.floating] = np.empty((0, 4, 4))
        self._level_information = np.linalg.inv(level_covariance)
        self._keyframes: dict[int, Keyframe] = {}
        self._factors: list[BetweenFactor] = []
        self._culled = CulledKeyframes()
        self._next = 0

    def __len__(self) -> int:
        return len(self._keyframes)

    def __getitem__(self, number: int) -> Keyframe:
        return self._keyframes[number]

    @property
    def numbers(self) -> list[int]:
        """Numbers of all keyframes."""
        return list(self._keyframes)

    @property
    def keyframes(self) -> list[Keyframe]:
        """All keyframes, in the order of `poses`."""
        return list(self._keyframes.values())

    @property
    def factors(self) -> tuple[BetweenFactor, ...]:
        """Measurements between keyframes; `first` and `second` are numbers of keyframes."""
        return tuple(self._factors)

    def take_number(self) -> int:
        """Take a number for a new keyframe."""
        number, self._next = self._next, self._next + 1
        return number

    def add(self, key: Keyframe) -> None:
        """Add a keyframe."""
        self._keyframes[key.number] = key
        self.poses = np.concatenate([self.poses, key.T_map_camera[None]])

    def add_factor(self, factor: BetweenFactor) -> None:
        """Add a measurement between two keyframes."""
        self._factors.append(factor)

    def pose_of(self, number: int, T_keyframe_camera: NDArray[np.floating]) -> NDArray[np.floating]:
        """See `KeyframeMap.pose_of`."""
        number, T_keyframe_camera = self._culled.substitute(number, T_keyframe_camera)
        return self[number].T_map_camera @ T_keyframe_camera

    def neighbours(self, number: int) -> list[int]:
        """A keyframe, or its substitute, and the keyframes connected to it by a factor."""
        number, _ = self._culled.substitute(number, np.eye(4))
        ends = [(factor.first, factor.second) for factor in self._factors]
        return [number, *(b if a == number else a for a, b in ends if number in (a, b))]

    def apart(self, T_map_camera: NDArray[np.floating]) -> NDArray[np.floating]:
        """(n,) normalised distances to all keyframes; a frame at 1 or more shows a new view."""
        translation, rotation = distances(self.poses, T_map_camera)
        depths = np.array([key.depth for key in self._keyframes.values()])
        s = self.settings
        return np.maximum(translation / (s.max_baseline * depths), rotation / s.max_rotation)

    def optimise(self, anyway: bool = False) -> bool:
        """Optimise the graph, move keyframes, and recompute their covariances.

        Args:
            anyway: Move keyframes even if the correction is small.

        Returns:
            Whether keyframes were moved.
        """
        optimised = self._pose_graph().optimised()
        there = np.stack([pose.as_matrix() for pose in optimised.poses])
        translation, rotation = (largest.max() for largest in distances(self.poses, there))
        s = self.settings
        moves = anyway or translation >= s.min_correction or rotation >= s.min_correction_rotation
        if moves:
            self.poses = there
        covariances = marginal_covariances(optimised, self.keyframes[0].covariance)
        for number, T, covariance in zip(self.numbers, self.poses, covariances, strict=True):
            self._keyframes[number] = replace(self[number], T_map_camera=T, covariance=covariance)
        return bool(moves)

    def _pose_graph(self) -> PoseGraph:
        """The pose graph; its poses are in the order of the keyframes."""
        index = {number: n for n, number in enumerate(self._keyframes)}
        factors = tuple(
            replace(factor, first=index[factor.first], second=index[factor.second])
            for factor in self._factors
        )
        levels = tuple(
            LevelFactor(index[number], orthonormal(key.T_base_camera), self._level_information)
            for number, key in self._keyframes.items()
            if key.T_base_camera is not None
        )
        return PoseGraph(tuple(map(orthonormal, self.poses)), factors, levels)

    def cull(self) -> int:
        """Remove the keyframe nearest to another one, never the first or the last.

        Its factors are transferred to the other one.

        Returns:
            The number of the culled keyframe.
        """
        numbers = self.numbers
        _, index, substitute_index = min(map(self._nearest_other, range(1, len(numbers) - 1)))
        number, substitute = numbers[index], numbers[substitute_index]
        T_substitute_culled = self[substitute].relative_pose(self[number].T_map_camera)
        self._culled.add(number, substitute, T_substitute_culled)
        max_factors = MAX_FACTORS_PER_KEYFRAME * self.settings.max_keyframes
        factors = transfer_factors(
            self._factors, number, substitute, orthonormal(T_substitute_culled)
        )
        self._factors = prune_factors(factors, max_factors)
        del self._keyframes[number]
        self.poses = np.delete(self.poses, index, axis=0)
        return number

    def _nearest_other(self, index: int) -> tuple[float, int, int]:
        apart = self.apart(self.poses[index])
        apart[index] = np.inf
        return float(apart.min()), index, int(apart.argmin())
