"""Rejects frames that cannot be used at all."""

from __future__ import annotations

import numpy as np

from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.sensing import RgbdFrame

MIN_MEDIAN_DEPTH_M, MAX_MEDIAN_DEPTH_M = 0.05, 50.0
"""A median depth outside of this range is in another unit."""
BLOCK_PX = 16
"""The median is taken over one pixel of each block of this side."""


class FrameCheck:
    """Checks order, depth and unit of the frames of a stream."""

    def __init__(self) -> None:
        """Start before the first frame."""
        self._stamp: float | None = None

    def outcome(self, frame: RgbdFrame) -> FrameOutcome | None:
        """Why a frame cannot be used; None if it can."""
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
