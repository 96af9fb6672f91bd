"""Tracking of the robot from the sightings of several cameras."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.localization.fusion import agreeing, difference, distance2, fused
from circumspect.localization.motion_filter import MotionFilter, shifted
from circumspect.localization.space_fix import BRIDGED, LOST, MOVED, TRACKED, Sighting, SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.tag_pose import TagPose

NO_CAMERA = "no camera sees the tag"


class CameraConsistency:
    """Counts how often each camera recently contradicted the others."""

    def __init__(self, comparison_window: int, min_contradictions: int) -> None:
        """Start without comparisons.

        Args:
            comparison_window: Number of recent comparisons that count.
            min_contradictions: Minimum number of contradictions; they must also be the majority.
        """
        self._comparison_window, self._min_contradictions = comparison_window, min_contradictions
        self._apart: dict[str, deque[float]] = {}
        self._disputes: dict[tuple[str, ...], deque[float]] = {}

    def add_comparison(
        self, agreed: Mapping[str, float], contradicted: Mapping[str, float]
    ) -> None:
        """Add the result of a comparison with the selected pose.

        Args:
            agreed: Cameras that agree, with the distance from the selected pose [m].
            contradicted: Cameras that contradict it, with the distance [m].
        """
        for name in agreed:
            self._apart.setdefault(name, self._empty()).append(0.0)
        for name, apart in contradicted.items():
            self._apart.setdefault(name, self._empty()).append(max(apart, 1e-9))
        for names in [n for n in self._disputes if set(n) <= {*agreed, *contradicted}]:
            del self._disputes[names]

    def add_dispute(self, cameras: Iterable[str], apart: float) -> None:
        """Add a contradiction between cameras that no majority resolves; distance in [m]."""
        names = tuple(sorted(cameras))
        self._disputes.setdefault(names, self._empty()).append(max(apart, 1e-9))

    @property
    def disputed_cameras(self) -> frozenset[str]:
        """Groups of cameras in which an unknown one moved."""
        judged = (
            names for names, apart in self._disputes.items() if self._median_distance(apart) > 0
        )
        return frozenset(name for names in judged for name in names)

    @property
    def moved(self) -> dict[str, float]:
        """Cameras that moved, with the median distance from the others [m]."""
        return {
            name: m
            for name, apart in self._apart.items()
            if (m := self._median_distance(apart)) > 0
        }

    @property
    def reports(self) -> tuple[str, ...]:
        """A sentence about each suspected camera."""
        reports = [
            f"camera '{name}' moved since calibration: it differs by {1e3 * apart:.0f} mm from the "
            "others; calibrate its extrinsics again"
            for name, apart in sorted(self.moved.items())
        ]
        for names, apart in sorted(self._disputes.items()):
            if self._median_distance(apart) > 0:
                which = " or ".join(f"'{name}'" for name in names)
                reports.append(
                    f"one of the cameras {which} moved since calibration: they are "
                    f"{1e3 * self._median_distance(apart):.0f} mm apart, and no third one "
                    "decides; calibrate their extrinsics again"
                )
        return tuple(reports)

    def _empty(self) -> deque[float]:
        return deque(maxlen=self._comparison_window)

    def _median_distance(self, apart: deque[float]) -> float:
        """Median distance of a camera that contradicts most of the time; 0 for others."""
        wrong = [value for value in apart if value > 0]
        if len(wrong) < self._min_contradictions or 2 * len(wrong) <= len(apart):
            return 0.0
        return float(np.median(wrong))


@dataclass(frozen=True)
class CameraSelection:
    """The cameras that are used for a fix.

    Attributes:
        names: Names of the cameras.
        note: What is wrong; None if nothing is.
        is_restart: Whether the motion filter must be restarted.
    """

    names: frozenset[str] = frozenset()
    note: str | None = None
    is_restart: bool = False


class SpaceTracker:
    """Fuses simultaneous sightings, tracks the robot and detects cameras that moved.

    Attributes:
        watch: Consistency of the cameras.
    """

    def __init__(self, settings: SpaceSettings | None = None) -> None:
        """Start without a pose."""
        self.settings = settings or SpaceSettings()
        self.watch = CameraConsistency(
            self.settings.comparison_window, self.settings.min_contradictions
        )
        self.reset()

    def reset(self) -> None:
        """Forget pose and time, but not the consistency of the cameras."""
        self._motion: MotionFilter | None = None
        self._bias = np.zeros((3, 3))
        self._measured = -np.inf
        self._stamp = -np.inf

    @property
    def stamp(self) -> float:
        """Time of the latest fix [s]; minus infinity before the first."""
        return self._stamp

    def take(self, stamp: float, sightings: Sequence[Sighting]) -> SpaceFix:
        """Fuse simultaneous sightings.

        Args:
            stamp: Their time [s], not earlier than that of the previous fix.
            sightings: At most one per camera.
        """
        self._stamp = stamp
        if self._motion is not None:
            self._motion.advance(stamp)
            if stamp - self._measured > self.settings.lost_after:
                self._motion = None
        sightings = [self._at(stamp, sighting) for sighting in sightings]
        choice = self._chosen([s for s in sightings if s.pose is not None])
        poses = [s.pose for s in sightings if s.camera in choice.names and s.pose is not None]
        if poses:
            self._follow(stamp, fused(poses), choice.is_restart)
        reports = tuple(self._with_reason(sighting, choice) for sighting in sightings)
        return self._fix(stamp, bool(poses), reports, choice.note)

    def _at(self, stamp: float, sighting: Sighting) -> Sighting:
        """The sighting extrapolated to the time of the fix."""
        seconds = stamp - sighting.stamp
        if sighting.pose is None or self._motion is None or seconds == 0:
            return sighting
        pose = sighting.pose
        moved = shifted(pose.T_map_base, seconds * self._motion.rates)
        return replace(sighting, pose=replace(pose, T_map_base=moved))

    def _chosen(self, seen: Sequence[Sighting]) -> CameraSelection:
        """Select the cameras to use."""
        if not seen:
            return CameraSelection(note=NO_CAMERA)
        moved = self.watch.moved
        trusted = [s for s in seen if s.camera not in moved]
        poses = [s.pose for s in trusted if s.pose is not None]
        if not poses:
            return CameraSelection(
                note=f"only {_listed(seen)} sees the tag, and that camera {MOVED}"
            )
        sets = agreeing(poses, self.settings.max_squared_distance)
        near = [group for group in sets if self._as_predicted(fused([poses[i] for i in group]))]
        if len(sets) > 1:
            self.watch.add_dispute((s.camera for s in trusted), _spread(poses))
            apart = f"{_listed(trusted)} are {1e3 * _spread(poses):.0f} mm apart"
            if len(near) != 1:
                return CameraSelection(note=f"{apart} and nothing decides")
            note = f"{apart}; the predicted motion decides"
            return CameraSelection(_names(trusted, near[0]), note)
        group = sets[0]
        if not near and len(group) == 1 and self._motion is not None:
            # A single camera that contradicts the predicted motion is an outlier.
            camera = trusted[group[0]].camera
            return CameraSelection(note=f"{camera} contradicts the predicted motion")
        names = _names(trusted, group)
        self._compare(fused([poses[i] for i in group]), names, seen)
        if not near and self._motion is not None:
            return CameraSelection(
                names, "carried away: cameras that agree see the robot elsewhere", True
            )
        if names <= self.watch.disputed_cameras:
            return CameraSelection(names, f"{_listed(trusted)}: in dispute with another camera")
        return CameraSelection(names)

    def _as_predicted(self, pose: TagPose) -> bool:
        """Whether a pose agrees with the predicted motion; False if there is none."""
        if self._motion is None:
            return False
        covariance = self._motion.covariance + self._bias + pose.covariance
        return (
            distance2(pose.T_map_base, self._motion.pose, covariance)
            <= self.settings.max_squared_distance
        )

    def _compare(self, decided: TagPose, names: frozenset[str], seen: Sequence[Sighting]) -> None:
        """Compare all cameras with the selected pose; a single camera cannot be compared."""
        if len(seen) < 2:
            return
        agreed, contradicted = {}, {}
        for sighting in seen:
            if sighting.pose is None:
                continue
            apart = _apart(sighting.pose, decided)
            covariance = sighting.pose.covariance + decided.covariance
            near = distance2(sighting.pose.T_map_base, decided.T_map_base, covariance)
            fits = sighting.camera in names or near <= self.settings.max_squared_distance
            (agreed if fits else contradicted)[sighting.camera] = apart
        self.watch.add_comparison(agreed, contradicted)

    def _with_reason(self, sighting: Sighting, choice: CameraSelection) -> Sighting:
        """The sighting with the reason why it is not used."""
        if sighting.pose is None or sighting.camera in choice.names:
            return sighting
        if sighting.camera in self.watch.moved:
            return replace(sighting, reason=MOVED)
        reason = "contradicts the other cameras" if choice.names else choice.note
        return replace(sighting, reason=reason)

    def _follow(self, stamp: float, pose: TagPose, is_restart: bool) -> None:
        """Update the motion filter with a pose, or restart it."""
        if self._motion is None or is_restart:
            rates = self.settings.acceleration, self.settings.turn_acceleration
            self._motion = MotionFilter(stamp, pose.T_map_base, pose.noise, *rates)
        else:
            self._motion.update(pose.T_map_base, pose.noise)
        # Errors that are constant over time are not averaged away.
        self._bias = pose.bias
        self._measured = stamp

    def _fix(
        self, stamp: float, seen: bool, sightings: tuple[Sighting, ...], note: str | None
    ) -> SpaceFix:
        if self._motion is None:
            return SpaceFix(stamp, LOST, None, None, sightings, note)
        state = TRACKED if seen else BRIDGED
        covariance = self._motion.covariance + self._bias
        return SpaceFix(stamp, state, self._motion.pose, covariance, sightings, note)


def _apart(pose: TagPose, other: TagPose) -> float:
    return float(np.linalg.norm(difference(pose.T_map_base, other.T_map_base)[:2]))


def _spread(poses: Sequence[TagPose]) -> float:
    """Maximum distance between two positions [m]."""
    places: NDArray[np.float64] = np.array([pose.T_map_base.xy for pose in poses])
    return float(np.linalg.norm(places[:, None] - places, axis=2).max())


def _listed(sightings: Sequence[Sighting]) -> str:
    names = sorted(sighting.camera for sighting in sightings)
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _names(sightings: Sequence[Sighting], group: Sequence[int]) -> frozenset[str]:
    return frozenset(sightings[i].camera for i in group)
