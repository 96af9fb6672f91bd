"""The odometry of a frame, among messages that come at other times."""

from __future__ import annotations

from collections import deque

from circumspect.geometry import PlanarPose, wrapped
from circumspect.sensing import Odometry

NEAR = 0.2
"""Odometry further away in time [s] tells nothing of a frame."""
KEPT = 10.0
"""Older messages are forgotten [s]."""


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
        """The odometry at a time [s]: between the two messages around it, or the nearest one.

        None where there is none within `NEAR`.
        """
        after = next((k for k, o in enumerate(self._heard) if o.stamp >= stamp), len(self._heard))
        around = [self._heard[k] for k in (after - 1, after) if 0 <= k < len(self._heard)]
        near = [o for o in around if abs(o.stamp - stamp) <= NEAR]
        exact = [o for o in near if o.stamp == stamp]
        if exact or not near:
            return exact[0] if exact else None
        return near[0] if len(near) == 1 else between(near[0], near[1], stamp)


def between(one: Odometry, other: Odometry, stamp: float) -> Odometry:
    """The odometry between two messages, as if the robot had driven an even arc."""
    share = (stamp - one.stamp) / (other.stamp - one.stamp)
    a, b = one.T_odom_base, other.T_odom_base
    turned = wrapped(b.yaw - a.yaw)
    x, y = (1 - share) * a.xy + share * b.xy
    return Odometry(
        stamp,
        PlanarPose(float(x), float(y), a.yaw + share * turned),
        (1 - share) * one.covariance + share * other.covariance,
        (1 - share) * one.forward + share * other.forward,
        (1 - share) * one.turn + share * other.turn,
    )
