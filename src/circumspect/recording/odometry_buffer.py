"""Odometry at the time of a frame, from messages at other times."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from circumspect.geometry import PlanarPose
from circumspect.recording.pose_interpolation import (
    HISTORY_S,
    MAX_INTERPOLATION_GAP_S,
    MAX_STAMP_DISTANCE_S,
    interpolated,
)
from circumspect.robot import arc
from circumspect.sensing import Odometry


class OdometryBuffer:
    """The odometry messages of the last seconds."""

    def __init__(self) -> None:
        self._messages: deque[Odometry] = deque()

    def add(self, odometry: Odometry) -> None:
        """Add a message; a late one is ignored.

        A message older than the whole history means that the clock was set back or that the last
        stamps were wrong; the buffer then starts again.
        """
        if self._messages and odometry.stamp < self._messages[-1].stamp - HISTORY_S:
            self._messages.clear()
        if self._messages and odometry.stamp <= self._messages[-1].stamp:
            return
        self._messages.append(odometry)
        while odometry.stamp - self._messages[0].stamp > HISTORY_S:
            self._messages.popleft()

    def covers(self, stamp: float) -> bool:
        """Whether a message at or after a time [s] has arrived."""
        return bool(self._messages) and self._messages[-1].stamp >= stamp

    def at(self, stamp: float) -> Odometry | None:
        """Odometry at a time [s]; None without a message within `MAX_STAMP_DISTANCE_S`.

        Between messages at most `MAX_INTERPOLATION_GAP_S` apart, motion along an arc is assumed.
        Next to a larger gap or at the end, the nearest message is extrapolated with its velocity.
        """
        after = next(
            (k for k, o in enumerate(self._messages) if o.stamp >= stamp), len(self._messages)
        )
        around = [self._messages[k] for k in (after - 1, after) if 0 <= k < len(self._messages)]
        nearest = min(around, key=lambda odometry: abs(odometry.stamp - stamp), default=None)
        if nearest is None or abs(nearest.stamp - stamp) > MAX_STAMP_DISTANCE_S:
            return None
        if nearest.stamp == stamp:
            return nearest
        if len(around) == 2 and around[1].stamp - around[0].stamp <= MAX_INTERPOLATION_GAP_S:
            return _interpolated(around[0], around[1], stamp)
        return _extrapolated(nearest, stamp)


def _interpolated(before: Odometry, after: Odometry, stamp: float) -> Odometry:
    """Odometry between two messages, assuming uniform motion along an arc."""
    fraction = (stamp - before.stamp) / (after.stamp - before.stamp)
    ends = before.T_odom_base.as_transform(), after.T_odom_base.as_transform()
    return Odometry(
        stamp,
        PlanarPose.from_transform(interpolated(*ends, fraction)),
        (1 - fraction) * before.covariance + fraction * after.covariance,
        (1 - fraction) * before.forward + fraction * after.forward,
        (1 - fraction) * before.turn + fraction * after.turn,
    )


def _extrapolated(odometry: Odometry, stamp: float) -> Odometry:
    """Odometry extrapolated with constant velocity."""
    time = stamp - odometry.stamp
    moved = arc(odometry.forward * time, odometry.turn * time)
    return replace(odometry, stamp=stamp, T_odom_base=odometry.T_odom_base @ moved)
