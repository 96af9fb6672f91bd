"""States of the tracker and the transitions between them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum, auto

import numpy as np

from circumspect.tracking.hypothesis import Hypothesis
from circumspect.tracking.tracking_settings import TrackingSettings


class TrackingState(StrEnum):
    """State of the tracker after the last frame.

    Attributes:
        INITIALISING: There is no map yet.
        TRACKING: Scans agree with the map; the pose is reliable.
        DEAD_RECKONING: The pose follows odometry or the last motion, because scans contain too
            little information or there are several hypotheses.
        LOST: Scans contradict every hypothesis; the camera may be anywhere.
    """

    INITIALISING = auto()
    TRACKING = auto()
    DEAD_RECKONING = auto()
    LOST = auto()


class Evidence(StrEnum):
    """Evidence of a frame about the best hypothesis.

    Attributes:
        MAP_STARTED: The frame is the first of the map.
        CONFIRMED: The scan agrees with the map, and there is no other hypothesis.
        UNDECIDED: The scan contains too little information, or there are other hypotheses.
        CONTRADICTED: The scans of several frames contradict the map.
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
    # An undecided frame does not relocalise a lost camera.
    (_S.LOST, _E.UNDECIDED): _S.LOST,
    (_S.LOST, _E.CONTRADICTED): _S.LOST,
}
"""The next state. The tracker stays INITIALISING until a frame starts a map."""


def next_state(state: TrackingState, evidence: Evidence) -> TrackingState:
    """The state after a frame."""
    return TRANSITIONS.get((state, evidence), state)


class TrackingStatus:
    """Updates the state over frames; no other class assigns it.

    Attributes:
        state: State of the tracker.
        reason: Why the pose is not reliable; empty if it is.
        unverified: Whether the pose is not reliable only because the scans contain too little
            information, without a contradiction.
    """

    def __init__(self, settings: TrackingSettings) -> None:
        """Start without a map."""
        self.state = TrackingState.INITIALISING
        self.reason = ""
        self.unverified = False
        self._settings = settings
        self._contradictions = 0

    def start(self) -> None:
        """Process the first frame of the map."""
        self.state, self.reason = next_state(self.state, Evidence.MAP_STARTED), ""

    def update(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Process a frame.

        Args:
            hypotheses: Remaining hypotheses, the most likely first.
        """
        best = hypotheses[0]
        if best.likelihood.contradicts or best.motion == "dead reckoning":
            self._contradictions += 1
        elif best.unmeasured == 0 and best.likelihood.recognises:
            self._contradictions = 0
        evidence, self.reason = self._evidence(best, len(hypotheses))
        self.state = next_state(self.state, evidence)
        in_doubt = self._contradictions > 0 or len(hypotheses) > 1
        self.unverified = self.state is TrackingState.DEAD_RECKONING and not in_doubt

    def _evidence(self, best: Hypothesis, hypotheses: int) -> tuple[Evidence, str]:
        """Evidence about the best hypothesis, and the reason why it is not reliable."""
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
        # Wheels may spin: a motion that no scan has verified is not reliable.
        if (distance := best.unmeasured_distance) > s.max_unverified:
            return Evidence.UNDECIDED, f"no scan has verified the last {1e3 * distance:.0f} mm"
        if self._contradictions:
            return Evidence.UNDECIDED, "no scan has confirmed the pose since a contradiction"
        return Evidence.CONFIRMED, ""
