"""What the tracker knows about the camera, and how that changes from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum, auto

import numpy as np

from circumspect.tracking.hypothesis import Hypothesis
from circumspect.tracking.tracking_settings import TrackingSettings


class TrackingState(StrEnum):
    """How far the pose of the last frame can be relied on.

    Attributes:
        INITIALISING: There is no map yet.
        TRACKING: Scans agree with the map; the pose is reliable.
        DEAD_RECKONING: The pose goes by odometry or by the last motion, because scans say too
            little or several hypotheses are alive.
        LOST: Scans contradict every hypothesis; the camera may be anywhere.
    """

    INITIALISING = auto()
    TRACKING = auto()
    DEAD_RECKONING = auto()
    LOST = auto()


class Evidence(StrEnum):
    """What a frame says about the best hypothesis.

    Attributes:
        MAP_STARTED: The frame is the first of the map.
        CONFIRMED: The scan agrees with the map there, and with no other hypothesis.
        UNDECIDED: The scan says too little, or other hypotheses are as likely.
        CONTRADICTED: The scan contradicts the map there, and does so for several frames.
    """

    MAP_STARTED = auto()
    CONFIRMED = auto()
    UNDECIDED = auto()
    CONTRADICTED = auto()


_S, _E = TrackingState, Evidence
TRANSITIONS: dict[tuple[TrackingState, Evidence], TrackingState] = {
    (_S.INITIALISING, _E.MAP_STARTED): _S.TRACKING,
    (_S.TRACKING, _E.CONFIRMED): _S.TRACKING,
    (_S.TRACKING, _E.UNDECIDED): _S.DEAD_RECKONING,
    (_S.TRACKING, _E.CONTRADICTED): _S.LOST,
    (_S.DEAD_RECKONING, _E.CONFIRMED): _S.TRACKING,
    (_S.DEAD_RECKONING, _E.UNDECIDED): _S.DEAD_RECKONING,
    (_S.DEAD_RECKONING, _E.CONTRADICTED): _S.LOST,
    (_S.LOST, _E.CONFIRMED): _S.TRACKING,
    # A frame that says nothing does not find a lost camera.
    (_S.LOST, _E.UNDECIDED): _S.LOST,
    (_S.LOST, _E.CONTRADICTED): _S.LOST,
}
"""The next state; without a map a frame that starts none leaves the tracker initialising."""


def next_state(state: TrackingState, evidence: Evidence) -> TrackingState:
    """The state after a frame."""
    return TRANSITIONS.get((state, evidence), state)


class TrackingStatus:
    """Follows the state over frames: the only place that assigns it.

    Attributes:
        state: What is known of the camera.
        reason: Why its pose is not reliable; empty if it is.
    """

    def __init__(self, settings: TrackingSettings) -> None:
        """Start without a map."""
        self.state = TrackingState.INITIALISING
        self.reason = ""
        self._settings = settings
        self._contradictions = 0

    def start(self) -> None:
        """The first frame of the map."""
        self.state, self.reason = next_state(self.state, Evidence.MAP_STARTED), ""

    def update(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Take note of a frame.

        Args:
            hypotheses: Those that are still possible, the most likely one first.
        """
        best = hypotheses[0]
        if best.likelihood.contradicts or best.motion == "dead reckoning":
            self._contradictions += 1
        elif best.unmeasured == 0 and best.likelihood.recognises:
            self._contradictions = 0
        evidence, self.reason = self._evidence(best, len(hypotheses))
        self.state = next_state(self.state, evidence)

    def _evidence(self, best: Hypothesis, hypotheses: int) -> tuple[Evidence, str]:
        """What the frame says about the best hypothesis, and why it is not reliable."""
        s = self._settings
        if best.likelihood.contradicts or best.motion == "dead reckoning":
            if self._contradictions >= s.max_contradictions:
                return Evidence.CONTRADICTED, "the scans contradict the map"
            return Evidence.UNDECIDED, "the scan contradicts the map"
        if hypotheses > 1:
            return Evidence.UNDECIDED, f"{hypotheses} poses are possible"
        rotation, translation = best.pose.sigmas
        if rotation >= s.max_rotation_sigma or translation >= s.max_translation_sigma:
            sigmas = f"{np.degrees(rotation):.1f}° and {1e3 * translation:.0f} mm"
            return Evidence.UNDECIDED, f"standard deviations of {sigmas}"
        # Wheels may spin: what no scan has verified is not relied on, whatever odometry claims.
        if (distance := best.unmeasured_distance) > s.max_unverified:
            return Evidence.UNDECIDED, f"no scan has verified the last {1e3 * distance:.0f} mm"
        if self._contradictions:
            return Evidence.UNDECIDED, "no scan has confirmed the pose since a contradiction"
        return Evidence.CONFIRMED, ""
