"""The few frames that the scene map is made of, and how they hold each other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import se3, se3_matrices
from circumspect.geometry.composition import between, composed
from circumspect.geometry.pose_distance import distances
from circumspect.mapping.gate import GateSettings
from circumspect.mapping.heirs import Heirs
from circumspect.mapping.keyframe import Keyframe
from circumspect.mapping.keyframe_pairs import (
    OLD,
    closes_a_loop,
    is_consecutive,
    pair_edge,
    showing_the_same,
)
from circumspect.mapping.pair_queue import PairQueue
from circumspect.mapping.surest_ways import (
    agreeing,
    by_surest_ways,
    share_of_variance,
)
from circumspect.mapping.wheel_grip import WheelGrip
from circumspect.mapping.wheels import Passage
from circumspect.pose_graph import (
    BetweenFactor,
    LevelFactor,
    PoseGraph,
    prune_factors,
    transfer_factors,
)
from circumspect.registration import RegistrationSettings, Scan, SurfaceMap
from circumspect.sensing import RgbdFrame

FOUND_AGAIN = 0.25
"""A fitted pair leads back to a known place if it makes the variance of the later one's place so
much smaller."""
EDGES_EACH = 8
"""So many edges a keyframe are kept once keyframes give way."""
TOGETHER = 8
"""So many keyframes are laid over each other at once."""


@dataclass(frozen=True)
class KeyframeSettings:
    """When a frame becomes a keyframe, and what is done with them.

    Attributes:
        shift, turn: A keyframe is this far [m], [rad] from those that hold the camera.
        most: So many are kept; the one that adds least gives way.
        rebuild_shift, rebuild_turn: Corrections from this size on [m], [rad] are carried out
            when a loop closed; smaller ones when the run ends.
    """

    shift: float = 0.2
    turn: float = float(np.radians(12.0))
    most: int = 240
    rebuild_shift: float = 0.004
    rebuild_turn: float = float(np.radians(0.3))


class Keyframes:
    """A bounded number of keyframes and a pose graph over them."""

    def __init__(
        self,
        voxel: float,
        settings: KeyframeSettings,
        registration: RegistrationSettings,
        gate: GateSettings,
        level_information: NDArray[np.float64],
    ) -> None:
        """Begin without any."""
        self.settings = settings
        self.corrections = 0
        """How often poses were corrected."""
        self.loops = 0
        """Edges that closed a loop."""
        self.grip = WheelGrip()
        """What the wheels are worth, by what is known now."""
        self._voxel, self._registration, self._gate = voxel, registration, gate
        self._level_information = level_information
        self._by_number: dict[int, Keyframe] = {}
        self._edges: list[BetweenFactor] = []
        self.queue = PairQueue()
        """What waits for being fitted."""
        self._heirs = Heirs()
        self._matrices: NDArray[np.float64] | None = None
        self._next = 0
        self._held: int | None = None
        self._agreed = -1

    def __len__(self) -> int:
        return len(self._by_number)

    def __getitem__(self, number: int) -> Keyframe:
        return self._by_number[number]

    def anchored(self, number: int, T_anchor_camera: RigidTransform) -> RigidTransform:
        """`T_map_camera`, now, of a frame that was taken near a keyframe.

        Args:
            number: The keyframe, even one that gave way since.
            T_anchor_camera: The frame's pose in the keyframe's.

        Raises:
            KeyError: The keyframe gave way so long ago that it is forgotten.
        """
        number, T_living_camera = self._heirs.living(number, T_anchor_camera)
        return composed(self[number].T_map_camera, T_living_camera)

    @property
    def numbers(self) -> list[int]:
        """Of all, in the order in which they were taken."""
        return list(self._by_number)

    @property
    def places(self) -> list[RigidTransform]:
        """`T_map_camera` of all."""
        return [key.T_map_camera for key in self._by_number.values()]

    def holding(self, T_map_camera: RigidTransform) -> tuple[int, float]:
        """The keyframe that a camera is held by now, and how far it is.

        That is the nearest of those that belong together with the last one that held it: taken
        shortly before or after, or all reconciled by the graph. A camera that comes back to where
        it began is held by the end of its way until the loop is closed.

        Args:
            T_map_camera: The next pose of the same camera.

        Returns:
            Its number, and its distance (from 1 on: far enough for a new keyframe).

        Raises:
            ValueError: There are none.
        """
        numbers, apart = np.array(self.numbers), self._apart(T_map_camera)
        if self._held is not None:
            belongs = np.abs(numbers - self._held) <= OLD
            if self._held <= self._agreed:
                belongs |= numbers <= self._agreed
            apart = np.where(belongs, apart, np.inf)
        best = int(apart.argmin())
        self._held = int(numbers[best])
        return self._held, float(apart[best])

    def found_again(self) -> None:
        """The camera was found by all that is known, not by where it had been before."""
        self._held = None

    def _apart(self, T_map_camera: RigidTransform) -> NDArray[np.float64]:
        shift, turn = distances(self._poses(), T_map_camera.as_matrix())
        return np.maximum(shift / self.settings.shift, turn / self.settings.turn)

    def _poses(self) -> NDArray[np.float64]:
        """(n, 4, 4) `T_map_camera` of all, until one of them changes."""
        if self._matrices is None:
            self._matrices = np.stack([T.as_matrix() for T in self.places])
        return self._matrices

    def covariance(
        self, T_map_camera: RigidTransform, to_scene: NDArray[np.floating]
    ) -> NDArray[np.floating]:
        """(6, 6) of a pose: that of the keyframe that holds it, and that of the fit.

        Args:
            T_map_camera: The pose.
            to_scene: (6, 6) of its place in the scene near by.
        """
        if not self._by_number:
            return to_scene
        key = self[self.holding(T_map_camera)[0]]
        held = se3.moved_covariance(between(T_map_camera, key.T_map_camera), key.covariance)
        return held + to_scene

    def add(
        self,
        T_map_camera: RigidTransform,
        to_scene: NDArray[np.floating],
        scan: Scan,
        frame: RgbdFrame,
        passage: Passage,
    ) -> Keyframe:
        """Take a frame in, and put down which others it is to be fitted to.

        Args:
            T_map_camera: Where it was taken from.
            to_scene: (6, 6) covariance of that in the scene near by.
            scan: What it shows.
            frame: The same, not thinned.
            passage: How the camera came there since the last keyframe.
        """
        number, self._next = self._next, self._next + 1
        covariance = self.covariance(T_map_camera, to_scene)
        key = Keyframe.of(
            number, T_map_camera, covariance, scan, frame, passage, self._held, to_scene
        )
        if self._by_number:
            others = list(self._by_number.values())
            last = others[-1].number
            same = showing_the_same(key, others, self._poses())
            self.queue.put((n, number) for n in [last, *(n for n in same if n != last)])
        self._by_number[number] = key
        self._matrices = None
        self._held = number
        if len(self) > self.settings.most:
            self._give_way()
        return key

    def seen_empty(self, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points lie where some keyframe looked through.

        Args:
            points_xyz: (n, 3) [m] map frame.
        """
        empty = np.zeros(len(points_xyz), bool)
        for key in self._by_number.values():
            others = np.flatnonzero(~empty)
            empty[others] = key.looks_through(points_xyz[others])
        return empty

    def fit_next(self, hurry: bool = False) -> None:
        """Fit the next pair that waits to each other: an edge of the graph.

        Args:
            hurry: Rather one that a correction needs.
        """
        self._fit(*self.queue.take(hurry))

    def _fit(self, first: int, second: int) -> None:
        edge = pair_edge(
            self[first], self[second], self._voxel, self._registration, self._gate, self.grip
        )
        if edge is None:
            return
        self._edges.append(edge)
        self.loops += int(closes_a_loop(first, second))
        if is_consecutive(first, second) or not agreeing([edge], self._by_number):
            return
        if share_of_variance(edge, self[first], self[second]) < FOUND_AGAIN:
            self._reconcile()

    def fit_what_wheels_held(self) -> None:
        """Fit consecutive keyframes anew where wheels held one to the other, by `grip`.

        At the begin of a drive nobody knew yet how much of their way the wheels lose.
        """
        for edge in [edge for edge in self._edges if self._is_held_by_wheels(edge)]:
            self._edges.remove(edge)
            self._fit(edge.first, edge.second)

    def _is_held_by_wheels(self, edge: BetweenFactor) -> bool:
        if edge.transferred or not is_consecutive(edge.first, edge.second):
            return False
        first, second = self[edge.first].passage, self[edge.second].passage
        return first.stretch != second.stretch and second.by_wheels is not None

    def graph(self) -> PoseGraph:
        """The pose graph; its poses are in the order of the keyframes."""
        place = {number: index for index, number in enumerate(self._by_number)}
        edges = tuple(
            replace(edge, first=place[edge.first], second=place[edge.second])
            for edge in self._edges
        )
        levels = tuple(
            LevelFactor(place[number], key.T_base_camera, self._level_information)
            for number, key in self._by_number.items()
            if key.T_base_camera is not None
        )
        return PoseGraph(tuple(key.T_map_camera for key in self._by_number.values()), edges, levels)

    def correct(self, anyway: bool = False) -> bool:
        """Optimise the graph and move the keyframes to where they belong.

        Args:
            anyway: Also where the correction is small.

        Returns:
            Whether they were moved.
        """
        graph = self.graph()
        poses = graph.optimised().poses
        there = np.stack([pose.as_matrix() for pose in poses])
        changes = se3_matrices.logs(se3_matrices.inverse(self._poses()) @ there)
        turn, shift = np.linalg.norm(changes.reshape(-1, 2, 3), axis=2).max(axis=0)
        s = self.settings
        moved = anyway or shift >= s.rebuild_shift or turn >= s.rebuild_turn
        if moved:
            for number, pose in zip(self._by_number, poses, strict=True):
                self._by_number[number] = replace(self[number], T_map_camera=pose)
            self._matrices = None
            self.corrections += 1
        self._reconcile()
        return moved

    def _reconcile(self) -> None:
        """Tell of all how well they are known by the fits that their poses agree with."""
        asked = [
            edge
            for edge in self._edges
            if not (edge.transferred or is_consecutive(edge.first, edge.second))
        ]
        sound = agreeing(asked, self._by_number)
        self._by_number = by_surest_ways(list(self._by_number.values()), sound)
        closing = [edge.second for edge in sound if closes_a_loop(edge.first, edge.second)]
        self._agreed = max([self._agreed, *closing])

    def scene(self) -> SurfaceMap:
        """The scene map of all keyframes."""
        scene, keys = SurfaceMap(self._voxel), list(self._by_number.values())
        # A few at a time: all at once would take many times the memory of the map.
        for start in range(0, len(keys), TOGETHER):
            few = keys[start : start + TOGETHER]
            scene = scene.with_surfaces([(key.surface, key.T_map_camera) for key in few])
        return scene

    def _give_way(self) -> None:
        """Take out the keyframe that is nearest to another one."""
        numbers, poses = list(self._by_number), self._poses()
        closest, least = (numbers[1], numbers[0]), np.inf
        for index, number in enumerate(numbers[1:-1], start=1):
            shift, turn = distances(poses, poses[index])
            apart = np.maximum(shift / self.settings.shift, turn / self.settings.turn)
            apart[index] = np.inf
            if apart.min() < least:
                least, closest = float(apart.min()), (number, numbers[int(apart.argmin())])
        gone, heir = closest
        # The chain of the drive goes over to the heir, too; it is fitted while both ends are there.
        for pair in self.queue.take_out(gone):
            if is_consecutive(*pair):
                self._fit(*pair)
        T_heir_gone = between(self[heir].T_map_camera, self[gone].T_map_camera)
        self._heirs.gave_way(gone, heir, T_heir_gone)
        edges = transfer_factors(self._edges, gone, heir, T_heir_gone)
        self._edges = prune_factors(edges, EDGES_EACH * self.settings.most)
        self._bequeath(gone, heir)
        del self._by_number[gone]
        self._matrices = None

    def _bequeath(self, gone: int, heir: int) -> None:
        """What a keyframe held is held by its parent, or by its heir."""
        if self._held == gone:
            self._held = heir
        left = self[gone]
        for number, key in list(self._by_number.items()):
            if key.parent == gone:
                back = between(key.T_map_camera, left.T_map_camera)
                both = key.since_parent + se3.moved_covariance(back, left.since_parent)
                self._by_number[number] = replace(key, parent=left.parent, since_parent=both)
