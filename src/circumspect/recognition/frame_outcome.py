"""Outcome of a frame, and the rejection of unusable frames."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from circumspect.sensing import FloorProblem, RgbdFrame

MIN_MEDIAN_DEPTH_M, MAX_MEDIAN_DEPTH_M = 0.05, 50.0
"""A median depth outside this range [m] is in another unit."""
BLOCK_PX = 16
"""The median is taken over one pixel of each block of this side [px]."""


class FrameCheck:
    """Checks order, depth and unit of the frames of a stream."""

    def __init__(self) -> None:
        """Start before the first frame."""
        self._stamp: float | None = None

    def check(self, frame: RgbdFrame) -> FrameOutcome | None:
        """Check the next frame; return why it cannot be used, None if it can."""
        if self._stamp is not None and frame.stamp <= self._stamp:
            return FrameOutcome.OUT_OF_ORDER
        self._stamp = frame.stamp
        if not frame.valid.any():
            return FrameOutcome.NO_DEPTH
        depths = frame.depth[::BLOCK_PX, ::BLOCK_PX]
        depths = depths[np.isfinite(depths)]
        if len(depths) and not MIN_MEDIAN_DEPTH_M < float(np.median(depths)) < MAX_MEDIAN_DEPTH_M:
            return FrameOutcome.WRONG_UNIT
        return None


class FrameOutcome(StrEnum):
    """Outcome of a frame; the values are the texts in logs and results."""

    CLASSIFIED = "classified"
    OUT_OF_ORDER = "not later than the frame before"
    WRONG_UNIT = "depths that no camera has; are they in metres?"
    NO_DEPTH = "no depth in the frame"
    NO_FLOOR = FloorProblem.NO_FLOOR.value
    BELOW_FLOOR = FloorProblem.BELOW_FLOOR.value
    NO_OBJECT = "no object in view"
    NO_POSE = "the pose is not reliable"
    TOO_LITTLE = "too little of the object seen to span a shape"
    TOO_WIDE = "what stands there is too wide for an object; is it the room?"
