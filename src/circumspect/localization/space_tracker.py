"""From what the cameras say to where the robot is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from circumspect.localization.camera_watch import CameraWatch
from circumspect.localization.fusion import agreeing, difference, distance2, fused
from circumspect.localization.motion_filter import MotionFilter, shifted
from circumspect.localization.sighting import MOVED, Sighting
from circumspect.localization.space_fix import BRIDGED, LOST, TRACKED, SpaceFix
from circumspect.localization.space_settings import SpaceSettings
from circumspect.localization.tag_pose import TagPose

NOBODY = "no camera sees the tag"


@dataclass(frozen=True)
class Choice:
    """Whom to believe.

    Attributes:
        names: The cameras.
        note: What is wrong on the whole; None where nothing is.
        anew: Whether the motion so far is void.
    """

    names: frozenset[str] = frozenset()
    note: str | None = None
    anew: bool = False


class SpaceTracker:
    """Fuses sightings of one time, follows the robot over time, and doubts cameras.

    Attributes:
        watch: Which cameras moved.
    """

    def __init__(self, settings: SpaceSettings | None = None) -> None:
        """Begin with a robot that nobody has seen."""
        self.settings = settings or SpaceSettings()
        self.watch = CameraWatch(self.settings.watched, self.settings.fewest)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget where the robot was and when; doubts about cameras stay."""
        self._motion: MotionFilter | None = None
        self._bias = np.zeros((3, 3))
        self._measured = -np.inf
        self._stamp = -np.inf

    @property
    def stamp(self) -> float:
        """Of the latest fix [s]; minus infinity before the first."""
        return self._stamp

    def take(self, stamp: float, sightings: Sequence[Sighting]) -> SpaceFix:
        """The sightings of one time.

        Args:
            stamp: That time [s], not before that of the fix before.
            sightings: At most one a camera.
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
            self._follow(stamp, fused(poses), choice.anew)
        told = tuple(self._judged(sighting, choice) for sighting in sightings)
        return self._fix(stamp, bool(poses), told, choice.note)

    def _at(self, stamp: float, sighting: Sighting) -> Sighting:
        """The sighting carried to the time of the fix by the motion so far."""
        seconds = stamp - sighting.stamp
        if sighting.pose is None or self._motion is None or seconds == 0:
            return sighting
        pose = sighting.pose
        moved = shifted(pose.T_map_base, seconds * self._motion.rates)
        return replace(sighting, pose=replace(pose, T_map_base=moved))

    def _chosen(self, seen: Sequence[Sighting]) -> Choice:
        """Whom to believe of the cameras that see the robot."""
        if not seen:
            return Choice(note=NOBODY)
        moved = self.watch.moved
        trusted = [s for s in seen if s.camera not in moved]
        poses = [s.pose for s in trusted if s.pose is not None]
        if not poses:
            return Choice(note=f"only {_listed(seen)} sees the tag, and that camera {MOVED}")
        sets = agreeing(poses, self.settings.gate)
        near = [group for group in sets if self._as_predicted(fused([poses[i] for i in group]))]
        if len(sets) > 1:
            self.watch.disputed((s.camera for s in trusted), _spread(poses))
            apart = f"{_listed(trusted)} are {1e3 * _spread(poses):.0f} mm apart"
            if len(near) != 1:
                return Choice(note=f"{apart} and nothing decides")
            return Choice(_names(trusted, near[0]), f"{apart}; the motion so far decides")
        group = sets[0]
        if not near and len(group) == 1 and self._motion is not None:
            # One camera against the motion so far: an outlier, as long as that is known.
            return Choice(note=f"{trusted[group[0]].camera} contradicts the motion so far")
        names = _names(trusted, group)
        self._compare(fused([poses[i] for i in group]), names, seen)
        if not near and self._motion is not None:
            return Choice(names, "carried away: cameras that agree see the robot elsewhere", True)
        if names <= self.watch.suspects:
            return Choice(names, f"{_listed(trusted)}: one that is in dispute with another")
        return Choice(names)

    def _as_predicted(self, pose: TagPose) -> bool:
        """Whether a pose fits to the motion so far; never where there is none."""
        if self._motion is None:
            return False
        covariance = self._motion.covariance + self._bias + pose.covariance
        return distance2(pose.T_map_base, self._motion.pose, covariance) <= self.settings.gate

    def _compare(self, decided: TagPose, names: frozenset[str], seen: Sequence[Sighting]) -> None:
        """Tell the watch who agrees with what was decided; one camera alone says nothing."""
        if len(seen) < 2:
            return
        agreed, contradicted = {}, {}
        for sighting in seen:
            if sighting.pose is None:
                continue
            apart = _apart(sighting.pose, decided)
            covariance = sighting.pose.covariance + decided.covariance
            near = distance2(sighting.pose.T_map_base, decided.T_map_base, covariance)
            fits = sighting.camera in names or near <= self.settings.gate
            (agreed if fits else contradicted)[sighting.camera] = apart
        self.watch.compared(agreed, contradicted)

    def _judged(self, sighting: Sighting, choice: Choice) -> Sighting:
        """With the reason why it is not used."""
        if sighting.pose is None or sighting.camera in choice.names:
            return sighting
        if sighting.camera in self.watch.moved:
            return replace(sighting, reason=MOVED)
        reason = "contradicts the other cameras" if choice.names else choice.note
        return replace(sighting, reason=reason)

    def _follow(self, stamp: float, pose: TagPose, anew: bool) -> None:
        """Let the filter have a pose, or begin with it."""
        if self._motion is None or anew:
            rates = self.settings.acceleration, self.settings.turn_acceleration
            self._motion = MotionFilter(stamp, pose.T_map_base, pose.noise, *rates)
        else:
            self._motion.update(pose.T_map_base, pose.noise)
        # What does not change from image to image is not averaged away by many of them.
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
    """The largest distance of two places [m]."""
    places: NDArray[np.float64] = np.array([pose.T_map_base.xy for pose in poses])
    return float(np.linalg.norm(places[:, None] - places, axis=2).max())


def _listed(sightings: Sequence[Sighting]) -> str:
    names = sorted(sighting.camera for sighting in sightings)
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _names(sightings: Sequence[Sighting], group: Sequence[int]) -> frozenset[str]:
    return frozenset(sightings[i].camera for i in group)
