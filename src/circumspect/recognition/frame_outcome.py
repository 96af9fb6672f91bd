"""What came of a frame."""

from __future__ import annotations

from enum import StrEnum

from circumspect.sensing import FloorFault


class FrameOutcome(StrEnum):
    """What came of a frame; the values are the texts in logs and results."""

    CLASSIFIED = "classified"
    OUT_OF_ORDER = "not later than the frame before"
    WRONG_UNIT = "depths that no camera has; are they in metres?"
    NO_DEPTH = "no depth in the frame"
    NO_FLOOR = FloorFault.NO_FLOOR.value
    BELOW_FLOOR = FloorFault.BELOW_FLOOR.value
    NO_OBJECT = "no object in view"
    NO_POSE = "the pose is not reliable"
    TOO_LITTLE = "too little of the object seen to span a shape"
    TOO_WIDE = "what stands there is too wide for an object; is it the room?"
