"""Track of the robot from the intelligent space during a run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory
from circumspect.localization.space_fix import BRIDGED, NO_TAG, TRACKED, SpaceFix
from circumspect.storage import atomic_open

LATE = "late"
"""A repeated fix, because all images were late."""
CLOCK_JUMP = "clock jump"
"""A repeated fix, because the stamps of all images jumped ahead."""
SET_BACK = "set back"
"""A fix of a time that occurs twice because a clock was set back; the other clock has more
poses."""


_EXCLUDED = {
    LATE: "were late",
    CLOCK_JUMP: "jumped ahead of the others",
    SET_BACK: "overlap others because a clock was set back",
}


@dataclass(frozen=True, eq=False)
class SpaceTrack:
    """Fixes in the order of time.

    Attributes:
        fixes: The path: one fix for each time with images.
        reports: Sentences about cameras and clocks.
        arrived: All fixes in the order of arrival, with the reason if excluded from the path; see
            `exclusion_reasons`.
    """

    fixes: tuple[SpaceFix, ...]
    reports: tuple[str, ...] = ()
    arrived: tuple[tuple[SpaceFix, str | None], ...] = ()

    @classmethod
    def of(cls, fixes: Iterable[SpaceFix], reports: Iterable[str] = ()) -> SpaceTrack:
        """Separate the path from the excluded fixes.

        Args:
            fixes: Fixes in the order of arrival.
            reports: Sentences about cameras and clocks.
        """
        fixes = tuple(fixes)
        arrived = tuple(zip(fixes, exclusion_reasons(fixes), strict=True))
        counts = Counter(why for _, why in arrived)
        document = [
            f"{counts[why]} fixes {words} and are not part of the path"
            for why, words in _EXCLUDED.items()
            if counts[why]
        ]
        path = tuple(fix for fix, why in arrived if why is None)
        return cls(path, (*reports, *document), arrived)

    @property
    def late(self) -> tuple[SpaceFix, ...]:
        """Fixes of late images; they are not part of the path."""
        return self._excluded(LATE)

    @property
    def clock_jumps(self) -> tuple[SpaceFix, ...]:
        """Fixes of images whose stamps jumped ahead; they are not part of the path."""
        return self._excluded(CLOCK_JUMP)

    @property
    def set_back(self) -> tuple[SpaceFix, ...]:
        """Fixes of times that occur twice after a clock was set back; not part of the path."""
        return self._excluded(SET_BACK)

    def _excluded(self, reason: str) -> tuple[SpaceFix, ...]:
        return tuple(fix for fix, why in self.arrived if why == reason)

    def write_log(self, path: Path) -> None:
        """Write one JSON line per fix, in the order of arrival; "excluded" is the reason if any.

        Args:
            path: The file.

        Raises:
            OutputError: The file cannot be written.
        """
        with atomic_open(path) as stream:
            for fix, why in self.arrived:
                document = fix.summary() if why is None else {**fix.summary(), "excluded": why}
                stream.write(json.dumps(document) + "\n")

    def known(self, bridged: bool = True) -> tuple[SpaceFix, ...]:
        """Fixes with a pose.

        Args:
            bridged: Whether to include predicted poses.
        """
        states = (TRACKED, BRIDGED) if bridged else (TRACKED,)
        return tuple(fix for fix in self.fixes if fix.state in states)

    def trajectory(self, bridged: bool = True) -> Trajectory | None:
        """Poses of `base_link` in map; None if there are none."""
        fixes = self.known(bridged)
        if not fixes:
            return None
        poses = [fix.T_map_base.as_transform() for fix in fixes if fix.T_map_base is not None]
        return Trajectory(np.array([fix.stamp for fix in fixes]), RigidTransform.concatenate(poses))

    @property
    def stated_error_m(self) -> float | None:
        """Root mean square of the stated position errors of tracked poses [m]."""
        return _rms([fix.position_sigma for fix in self.known(bridged=False)])

    @property
    def stated_yaw_error_deg(self) -> float | None:
        """Root mean square of the stated heading errors of tracked poses [degrees]."""
        error = _rms([fix.yaw_sigma for fix in self.known(bridged=False)])
        return None if error is None else float(np.degrees(error))

    def summary(self) -> dict[str, Any]:
        """Counts and stated errors as JSON types."""
        states = Counter(fix.state for fix in self.fixes)
        views: Counter[str] = Counter(name for fix in self.fixes for name in fix.cameras)
        return {
            "times": len(self.fixes),
            "late": len(self.late),
            "clock_jumps": len(self.clock_jumps),
            "set_back": len(self.set_back),
            "states": dict(states),
            "cameras": dict(sorted(views.items())),
            "rejected": self._rejected(),
            "space_error_m": self.stated_error_m,
            "space_yaw_error_deg": self.stated_yaw_error_deg,
            "reports": list(self.reports),
        }

    def _rejected(self) -> dict[str, int]:
        """Number of each rejection reason per camera, with missing tags last."""
        refused = [
            sighting for fix, _ in self.arrived for sighting in fix.sightings if sighting.reason
        ]
        counts = Counter((s.camera, s.reason) for s in refused)
        # The detail differs each time; the first one is shown.
        first = {(s.camera, s.reason): s.detail for s in reversed(refused)}
        rejected: dict[str, int] = {}
        for key in sorted(counts, key=lambda key: (key[1] == NO_TAG, -counts[key])):
            detail = "" if first[key] is None else f" (first: {first[key]})"
            rejected[f"{key[0]}: {key[1]}{detail}"] = counts[key]
        return rejected


def _rms(values: list[float]) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if values else None


def exclusion_reasons(fixes: Sequence[SpaceFix]) -> tuple[str | None, ...]:
    """Why each fix is excluded from the path: `LATE`, `CLOCK_JUMP`, `SET_BACK`; None if it is not.

    Args:
        fixes: Fixes in the order of arrival.
    """
    why: list[str | None] = [None] * len(fixes)
    segments: list[list[int]] = []
    before = float("inf")
    for number, fix in enumerate(fixes):
        if fix.stamp == before:
            why[number] = CLOCK_JUMP if _has_jumped(fix) else LATE
        elif fix.stamp > before:
            segments[-1].append(number)
        else:
            segments.append([number])
        before = fix.stamp
    for number in _overlapping(fixes, segments):
        why[number] = SET_BACK
    return tuple(why)


def _overlapping(fixes: Sequence[SpaceFix], segments: Iterable[list[int]]) -> list[int]:
    """Numbers of the fixes to exclude so that segments with different clocks form one path."""
    path: list[int] = []
    left_out: list[int] = []
    for segment in segments:
        begin = fixes[segment[0]].stamp
        end = fixes[path[-1]].stamp if path else -float("inf")
        # Fixes of the time span that both contain.
        old = [number for number in path if fixes[number].stamp >= begin]
        new = [number for number in segment if fixes[number].stamp <= end]
        if _poses(fixes, new) > _poses(fixes, old):
            left_out += old
            path = [*path[: len(path) - len(old)], *segment]
        else:
            left_out += new
            path += segment[len(new) :]
    return left_out


def _poses(fixes: Sequence[SpaceFix], numbers: Iterable[int]) -> int:
    return sum(fixes[number].T_map_base is not None for number in numbers)


def _has_jumped(fix: SpaceFix) -> bool:
    """Whether all images are later than the fix."""
    return bool(fix.sightings) and all(s.stamp > fix.stamp for s in fix.sightings)
