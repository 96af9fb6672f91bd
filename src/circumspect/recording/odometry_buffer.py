"""The odometry of a frame, among messages that come at other times."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from circumspect.geometry import PlanarPose
from circumspect.recording.pose_interpolation import APART, KEPT, NEAR, between
from circumspect.robot import arc
from circumspect.sensing import Odometry


class OdometryBuffer:
    """The last odometry messages."""

    def __init__(self) -> None:
        self._heard: deque[Odometry] = deque()

    def heard(self, odometry: Odometry) -> None:
        """Take a message in; one that comes late is left out.

        One that is older than all that is kept belongs to a clock that was set back, or the last
        ones had stamps from nowhere: it begins anew.
        """
        if self._heard and odometry.stamp < self._heard[-1].stamp - KEPT:
            self._heard.clear()
        if self._heard and odometry.stamp <= self._heard[-1].stamp:
            return
        self._heard.append(odometry)
        while odometry.stamp - self._heard[0].stamp > KEPT:
            self._heard.popleft()

    def reaches(self, stamp: float) -> bool:
        """Whether messages from a time on [s] are there already."""
        return bool(self._heard) and self._heard[-1].stamp >= stamp

    def at(self, stamp: float) -> Odometry | None:
        """The odometry at a time [s], or None where no message within `NEAR` tells it.

        Between two messages no further than `APART` from each other it is on the even arc. A
        message that is left alone by a gap or by the end is carried on by its own velocity.
        """
        after = next((k for k, o in enumerate(self._heard) if o.stamp >= stamp), len(self._heard))
        around = [self._heard[k] for k in (after - 1, after) if 0 <= k < len(self._heard)]
        nearest = min(around, key=lambda odometry: abs(odometry.stamp - stamp), default=None)
        if nearest is None or abs(nearest.stamp - stamp) > NEAR:
            return None
        if nearest.stamp == stamp:
            return nearest
        if len(around) == 2 and around[1].stamp - around[0].stamp <= APART:
            return _on_the_arc(around[0], around[1], stamp)
        return _carried(nearest, stamp)


def _on_the_arc(before: Odometry, after: Odometry, stamp: float) -> Odometry:
    """The odometry between two messages, as if the robot had driven an even arc."""
    share = (stamp - before.stamp) / (after.stamp - before.stamp)
    ends = before.T_odom_base.as_transform(), after.T_odom_base.as_transform()
    return Odometry(
        stamp,
        PlanarPose.from_transform(between(*ends, share)),
        (1 - share) * before.covariance + share * after.covariance,
        (1 - share) * before.forward + share * after.forward,
        (1 - share) * before.turn + share * after.turn,
    )


def _carried(odometry: Odometry, stamp: float) -> Odometry:
    """The odometry a little later or earlier, at the same velocity."""
    time = stamp - odometry.stamp
    moved = arc(odometry.forward * time, odometry.turn * time)
    return replace(odometry, stamp=stamp, T_odom_base=odometry.T_odom_base @ moved)
