"""The keyframe map: keyframes, their pose graph and their surface map."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import orthonormal
from circumspect.motion import PoseWithCovariance
from circumspect.pose_graph.factors import BetweenFactor
from circumspect.pose_graph.keyframe import Keyframe
from circumspect.pose_graph.keyframe_graph import KeyframeGraph, KeyframeSettings
from circumspect.pose_graph.loop_closure import closes_loop, covisible, registered
from circumspect.registration import (
    CompactSurface,
    FreeSpace,
    RegistrationSettings,
    Scan,
    ScanSurface,
    SurfaceMap,
    violated_points,
)
from circumspect.sensing import RgbdFrame

MAP_SIGMAS = np.array([np.radians(0.03)] * 3 + [0.0005] * 3)
"""Standard deviations of the local map's errors, shared by all scans registered to it [rad, m]."""
FIRST_SIGMA = 1e-4
"""Standard deviation of the first keyframe [rad, m]: it defines the map frame."""
MIN_DEPTH_M = 0.5
"""Lower bound of the depth that baselines of keyframes are compared with [m]."""
MAX_PENDING = 4
"""If more pairs are pending, two are registered per frame instead of one."""
MAX_LOOP_DELAY = 3
"""Maximum number of frames until a closed loop is optimised."""
MERGED_TOGETHER = 8
"""Number of surfaces merged into the surface map at once; bounds the memory."""
NEARBY_KEYFRAMES = 40
"""Number of nearest keyframes in which free space is looked up."""


class KeyframeMap:
    """A bounded number of keyframes with their pose graph and surface map.

    Attributes:
        surface_map: Target of scan registration.
        corrections: Number of times that optimisation moved keyframes.
    """

    def __init__(
        self,
        voxel: float,
        level_covariance: NDArray[np.floating],
        settings: KeyframeSettings | None = None,
        registration: RegistrationSettings | None = None,
    ) -> None:
        """Start empty.

        Args:
            voxel: Resolution of the surface map [m].
            level_covariance: (3, 3) of roll [rad], pitch [rad] and height [m] of the base.
            settings: Selection and correction of keyframes.
            registration: Settings of the registration between keyframes.
        """
        self.surface_map = SurfaceMap(voxel)
        self.corrections = 0
        self._graph = KeyframeGraph(level_covariance, settings or KeyframeSettings())
        self._voxel = voxel
        self._registration = registration or RegistrationSettings()
        self._pending: deque[tuple[int, int]] = deque()
        self._violated = np.empty(0, np.int64)
        self._loop_is_new, self._frames_since_loop = False, 0

    def __len__(self) -> int:
        return len(self._graph)

    def __getitem__(self, number: int) -> Keyframe:
        return self._graph[number]

    @property
    def poses(self) -> NDArray[np.floating]:
        """(n, 4, 4) `T_map_camera` of all keyframes."""
        return self._graph.poses

    @property
    def factors(self) -> tuple[BetweenFactor, ...]:
        """Measurements between keyframes; `first` and `second` are numbers of keyframes."""
        return self._graph.factors

    @property
    def violated(self) -> NDArray[np.int64]:
        """Ascending keys of map points that a keyframe sees through: means over thin parts."""
        return self._violated

    def pose_of(self, number: int, T_keyframe_camera: NDArray[np.floating]) -> NDArray[np.floating]:
        """(4, 4) current `T_map_camera` of a frame near a keyframe.

        Args:
            number: Number of the keyframe, which may have been culled.
            T_keyframe_camera: (4, 4) pose of the frame relative to the keyframe.

        Raises:
            KeyError: The keyframe was culled too long ago.
        """
        return self._graph.pose_of(number, T_keyframe_camera)

    def reference(self, T_map_camera: NDArray[np.floating], last: int | None) -> int:
        """The reference keyframe of a camera: the nearest among the neighbours of the last one.

        Neighbours are connected by a factor of the graph. A camera that returns to old keyframes
        is referenced to the recent ones until a loop closure connects both.

        Args:
            T_map_camera: (4, 4) pose of the camera.
            last: Reference keyframe of the last frame; None after relocalisation.
        """
        numbers, apart = np.array(self._graph.numbers), self._graph.apart(T_map_camera)
        if last is not None:
            apart = np.where(np.isin(numbers, self._graph.neighbours(last)), apart, np.inf)
        return int(numbers[apart.argmin()])

    def covariance(self, pose: PoseWithCovariance, reference: int) -> NDArray[np.floating]:
        """(6, 6) covariance of a pose since the first keyframe.

        Args:
            pose: The pose with its covariance in the local map.
            reference: Its reference keyframe.
        """
        back = se3_matrices.inverse(self[reference].relative_pose(pose.T_map_camera))
        Ad = se3_matrices.adjoint(back)
        return Ad @ self[reference].covariance @ Ad.T + pose.covariance + np.diag(MAP_SIGMAS**2)

    def shows_new_view(
        self, T_map_camera: NDArray[np.floating], reference: int, overlap: float
    ) -> bool:
        """Whether the view of a frame is new enough for a keyframe.

        Args:
            T_map_camera: (4, 4) pose of the frame.
            reference: Its reference keyframe.
            overlap: Fraction of its points that lie on the map.
        """
        apart = self._graph.apart(T_map_camera)[self._graph.numbers.index(reference)]
        s = self._graph.settings
        return bool(apart >= 1 or (overlap < s.min_overlap and apart >= s.min_step))

    def add(
        self, frame: RgbdFrame, scan: Scan, pose: PoseWithCovariance, reference: int | None
    ) -> Keyframe:
        """Add a keyframe and its surface.

        Args:
            frame: The frame.
            scan: Its scan.
            pose: Its pose with the covariance in the local map.
            reference: Its reference keyframe; None for the first keyframe.
        """
        number = self._graph.take_number()
        T, mount = pose.T_map_camera, frame.T_base_camera
        surface = ScanSurface.from_scan(scan)
        if mount is not None:
            surface = surface.with_vertical_floor_normals(orthonormal(T))
        key = Keyframe(
            number, T, pose.covariance, CompactSurface.from_surface(surface),
            FreeSpace.from_frame(frame), max(MIN_DEPTH_M, float(np.median(scan.points_xyz[:, 2]))),
            None if mount is None else mount.as_matrix(),
        )  # fmt: skip
        if reference is None:
            key = replace(key, covariance=np.eye(6) * FIRST_SIGMA**2)
        else:
            key = replace(key, covariance=self.covariance(pose, reference))
            self._connect(key, pose, reference)
        transform = orthonormal(T)
        self.surface_map = self.surface_map.with_surface(key.surface, transform)
        seen_through = violated_points(frame, self.surface_map, transform)
        self._violated = np.union1d(self._violated, seen_through)
        self._graph.add(key)
        if len(self) > self._graph.settings.max_keyframes:
            culled = self._graph.cull()
            self._pending = deque(pair for pair in self._pending if culled not in pair)
        return key

    def _connect(self, key: Keyframe, pose: PoseWithCovariance, reference: int) -> None:
        """Add the factor of tracking, and queue the registration of covisible keyframes."""
        first = self[reference]
        measured = orthonormal(first.relative_pose(key.T_map_camera))
        information = np.linalg.inv(pose.covariance + np.diag(MAP_SIGMAS**2))
        self._graph.add_factor(BetweenFactor(reference, key.number, measured, information))
        found = covisible(key, self._graph.keyframes, self.poses)
        self._pending.extend((other.number, key.number) for other in found)

    def free_space_contains(
        self, points_xyz: NDArray[np.floating], T_map_camera: NDArray[np.floating]
    ) -> NDArray[np.bool_]:
        """Which points lie in the free space of keyframes near a camera.

        Args:
            points_xyz: (n, 3) [m] map frame.
            T_map_camera: (4, 4) pose of the camera.
        """
        numbers, apart = self._graph.numbers, self._graph.apart(T_map_camera)
        free = np.zeros(len(points_xyz), bool)
        for index in np.argsort(apart)[:NEARBY_KEYFRAMES]:
            others = np.flatnonzero(~free)
            if not len(others):
                break
            free[others] = self[numbers[index]].sees_through(points_xyz[others])
        return free

    @property
    def has_pending(self) -> bool:
        """Whether registrations of keyframe pairs are pending."""
        return bool(self._pending)

    def process_pending(self) -> bool:
        """Register one or two pending pairs, and optimise after a loop closure.

        Optimisation waits until no pair is pending, for at most `MAX_LOOP_DELAY` frames.

        Returns:
            Whether keyframes were moved.
        """
        for _ in range(2 if len(self._pending) > MAX_PENDING else 1):
            if self._pending:
                self._register(*self._pending.popleft())
        self._frames_since_loop += self._loop_is_new
        waited = not self._pending or self._frames_since_loop >= MAX_LOOP_DELAY
        return self._loop_is_new and waited and self.optimise()

    def finalise(self) -> bool:
        """Register all pending pairs and optimise; returns whether keyframes were moved."""
        while self._pending:
            self._register(*self._pending.popleft())
        return len(self) > 1 and self.optimise(anyway=True)

    def optimise(self, anyway: bool = False) -> bool:
        """Optimise the graph, and rebuild the surface map if keyframes were moved.

        Args:
            anyway: Move keyframes even if the correction is small.

        Returns:
            Whether keyframes were moved.
        """
        self._loop_is_new, self._frames_since_loop = False, 0
        moved = self._graph.optimise(anyway)
        if moved:
            self.corrections += 1
            self._merge_surfaces()
        return moved

    def _merge_surfaces(self) -> None:
        merged, keys = SurfaceMap(self._voxel), self._graph.keyframes
        for start in range(0, len(keys), MERGED_TOGETHER):
            some = keys[start : start + MERGED_TOGETHER]
            merged = merged.with_surfaces(
                [(key.surface, orthonormal(key.T_map_camera)) for key in some]
            )
        self.surface_map = merged

    def _register(self, first: int, second: int) -> None:
        factor = registered(self[first], self[second], self._voxel, self._registration)
        if factor is not None:
            self._graph.add_factor(factor)
            self._loop_is_new |= closes_loop(first, second)
