"""All that the intelligent space said during a run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import Trajectory
from circumspect.localization.order_of_time import LATE, LEAP, SET_BACK, apart
from circumspect.localization.sighting import NO_TAG
from circumspect.localization.space_fix import BRIDGED, TRACKED, SpaceFix
from circumspect.storage import atomic_open

_APART = {
    LATE: "came late",
    LEAP: "leapt ahead of the others",
    SET_BACK: "of a clock that was set back overlap others",
}


@dataclass(frozen=True, eq=False)
class SpaceTrack:
    """Fixes in the order of time.

    Attributes:
        fixes: One for each time that there were images of: the path.
        reports: What was noticed about cameras and clocks.
        arrived: All fixes in the order of arrival, those that are part of no path among them, each
            with the reason why it is not; see `apart`.
    """

    fixes: tuple[SpaceFix, ...]
    reports: tuple[str, ...] = ()
    arrived: tuple[tuple[SpaceFix, str | None], ...] = ()

    @classmethod
    def of(cls, fixes: Iterable[SpaceFix], reports: Iterable[str] = ()) -> SpaceTrack:
        """Those that follow each other in time, and the others apart.

        Args:
            fixes: In the order of arrival.
            reports: What was noticed.
        """
        fixes = tuple(fixes)
        arrived = tuple(zip(fixes, apart(fixes), strict=True))
        counts = Counter(why for _, why in arrived)
        told = [
            f"{counts[why]} times {words} and are part of no path"
            for why, words in _APART.items()
            if counts[why]
        ]
        path = tuple(fix for fix, why in arrived if why is None)
        return cls(path, (*reports, *told), arrived)

    @property
    def late(self) -> tuple[SpaceFix, ...]:
        """Fixes without news, of images that came late; they are part of no path."""
        return self._apart(LATE)

    @property
    def leaps(self) -> tuple[SpaceFix, ...]:
        """Fixes without news, of images whose stamps leapt ahead; nor are they."""
        return self._apart(LEAP)

    @property
    def set_back(self) -> tuple[SpaceFix, ...]:
        """Fixes of times that were told twice, as a clock was set back; nor are they."""
        return self._apart(SET_BACK)

    def _apart(self, reason: str) -> tuple[SpaceFix, ...]:
        return tuple(fix for fix, why in self.arrived if why == reason)

    def write_log(self, path: Path) -> None:
        """Write a JSON line a fix, in the order of arrival; "apart" says why it is in no path.

        Args:
            path: The file.

        Raises:
            OutputError: It can not be written.
        """
        with atomic_open(path) as stream:
            for fix, why in self.arrived:
                told = fix.summary() if why is None else {**fix.summary(), "apart": why}
                stream.write(json.dumps(told) + "\n")

    def known(self, bridged: bool = True) -> tuple[SpaceFix, ...]:
        """Fixes that have a pose.

        Args:
            bridged: Those that no camera measured, too.
        """
        states = (TRACKED, BRIDGED) if bridged else (TRACKED,)
        return tuple(fix for fix in self.fixes if fix.state in states)

    def trajectory(self, bridged: bool = True) -> Trajectory | None:
        """Poses of `base_link` in map; None where there is none."""
        fixes = self.known(bridged)
        if not fixes:
            return None
        poses = [fix.T_map_base.as_transform() for fix in fixes if fix.T_map_base is not None]
        return Trajectory(np.array([fix.stamp for fix in fixes]), RigidTransform.concatenate(poses))

    @property
    def stated_error_m(self) -> float | None:
        """Root mean square of the places' standard deviations where the robot was tracked [m]."""
        return _rms([fix.position_sigma for fix in self.known(bridged=False)])

    @property
    def stated_yaw_error_deg(self) -> float | None:
        """The same of the heading [degrees]."""
        error = _rms([fix.yaw_sigma for fix in self.known(bridged=False)])
        return None if error is None else float(np.degrees(error))

    def summary(self) -> dict[str, Any]:
        """Counts and stated errors, JSON types."""
        states = Counter(fix.state for fix in self.fixes)
        views: Counter[str] = Counter(name for fix in self.fixes for name in fix.cameras)
        return {
            "times": len(self.fixes),
            "late": len(self.late),
            "leaps": len(self.leaps),
            "set_back": len(self.set_back),
            "states": dict(states),
            "cameras": dict(sorted(views.items())),
            "rejected": self._rejected(),
            "space_error_m": self.stated_error_m,
            "space_yaw_error_deg": self.stated_yaw_error_deg,
            "reports": list(self.reports),
        }

    def _rejected(self) -> dict[str, int]:
        """How often a camera gave which reason, tags that were seen before those not in view."""
        refused = [
            sighting for fix, _ in self.arrived for sighting in fix.sightings if sighting.reason
        ]
        counts = Counter((s.camera, s.reason) for s in refused)
        # A detail, a misfit for example, is another one each time: the first stands for all.
        first = {(s.camera, s.reason): s.detail for s in reversed(refused)}
        rejected: dict[str, int] = {}
        for key in sorted(counts, key=lambda key: (key[1] == NO_TAG, -counts[key])):
            detail = "" if first[key] is None else f" (first: {first[key]})"
            rejected[f"{key[0]}: {key[1]}{detail}"] = counts[key]
        return rejected


def _rms(values: list[float]) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if values else None
