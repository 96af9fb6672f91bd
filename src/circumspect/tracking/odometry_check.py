"""Leaves out odometry that is on another clock than the images, or does not fit their motion."""

from __future__ import annotations

import logging
from collections import deque
from dataclasses import replace

import numpy as np

from circumspect.geometry import PlanarPose
from circumspect.sensing import RgbdFrame
from circumspect.tracking.odometry_lag import contradicting_motions, odometry_lag
from circumspect.tracking.pose_estimate import PoseEstimate

MAX_STAMP_DIFFERENCE_S = 1.0
"""Odometry with a stamp farther from that of its frame belongs to another clock."""
MIN_FRAMES, MIN_SPAN_S, MIN_INTERVAL_S = 20, 20.0, 0.2
"""The window holds at least so many frames and so much time [s]; frames in it are at least
`MIN_INTERVAL_S` apart [s]."""
RECENT_MOTIONS, MAX_CONTRADICTING = 10, 5
"""Odometry is wrong if more than `MAX_CONTRADICTING` of so many last motions contradict it, and
right again if no more of as many do."""

DIFFERENT_CLOCKS = "odometry and images are on different clocks"
CONTRADICTED = "odometry contradicts the motion of the images"

_log = logging.getLogger(__name__)


class OdometryCheck:
    """Removes odometry from frames if its clock is not that of the images, or if it is wrong.

    Odometry that is wrong is used again once it fits the images.

    Attributes:
        warning: Why odometry is not used; empty if it is.
    """

    def __init__(self) -> None:
        """Assume that the odometry is right."""
        self.warning = ""
        self._lag: float | None = None
        self._is_wrong = False
        self._logged = set[str]()
        self._rows: deque[tuple[float, ...]] = deque()

    def checked(self, frame: RgbdFrame) -> RgbdFrame:
        """The frame, without its odometry if that is not to be used."""
        self.warning = self._clock_warning(frame)
        if not self.warning and self._is_wrong and frame.odometry is not None:
            self.warning = CONTRADICTED
        if not self.warning:
            return frame
        kind = self.warning.split(":")[0]
        if kind not in self._logged:
            _log.warning("%s; poses are found without odometry", self.warning)
            self._logged.add(kind)
        return replace(frame, odometry=None)

    def _clock_warning(self, frame: RgbdFrame) -> str:
        if self._lag is not None:
            order = "lags behind" if self._lag > 0 else "runs ahead of"
            return f"{DIFFERENT_CLOCKS}: odometry {order} the images by {abs(self._lag):.1f} s"
        apart = _stamp_difference(frame)
        if apart <= MAX_STAMP_DIFFERENCE_S:
            return ""
        return f"{DIFFERENT_CLOCKS}: their stamps differ by {apart:.1f} s"

    def update(self, frame: RgbdFrame, pose: PoseEstimate) -> None:
        """Compare the motion of a frame with its odometry.

        Args:
            frame: The frame, before it was `checked`.
            pose: Its pose.
        """
        if frame.odometry is None or pose.T_map_base is None:
            return
        if _stamp_difference(frame) > MAX_STAMP_DIFFERENCE_S:
            return
        if self._rows and frame.stamp - self._rows[-1][0] < MIN_INTERVAL_S - 1e-6:
            return
        registered = _row(pose.T_map_base) if pose.reliable else (np.nan,) * 3
        self._rows.append((frame.stamp, *registered, *_row(frame.odometry.T_odom_base)))
        while len(self._rows) > MIN_FRAMES and self._rows[-1][0] - self._rows[0][0] > MIN_SPAN_S:
            self._rows.popleft()
        rows = np.array(self._rows)
        motions = rows[:, 0], rows[:, 1:4], rows[:, 4:]
        recent = contradicting_motions(*motions)[-RECENT_MOTIONS:]
        # Too few motions say nothing new.
        if len(recent) == RECENT_MOTIONS or not self._is_wrong:
            self._is_wrong = int(recent.sum()) > MAX_CONTRADICTING
        # An even motion says nothing of a lag that is known.
        self._lag = None if self._is_wrong else odometry_lag(*motions) or self._lag


def _stamp_difference(frame: RgbdFrame) -> float:
    return 0.0 if frame.odometry is None else abs(frame.odometry.stamp - frame.stamp)


def _row(pose: PlanarPose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw
