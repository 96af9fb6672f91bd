"""What the tracker knows about the camera, and how that changes from frame to frame."""

from __future__ import annotations

from enum import StrEnum, auto


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
