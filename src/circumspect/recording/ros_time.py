"""Conversion of ROS time stamps."""

from __future__ import annotations

from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import message

NANOSECONDS = 1_000_000_000
END_NS = 2**31 * NANOSECONDS
"""End of the range of ROS stamps; seconds are signed 32-bit numbers."""


def nanoseconds(stamp: float) -> int:
    """Convert a stamp from seconds to nanoseconds.

    Raises:
        InputError: The stamp is negative or exceeds 32 bits.
    """
    if not 0 <= stamp * NANOSECONDS < END_NS - 0.5:
        raise InputError(f"the stamp {stamp} s can not be recorded; ROS stamps start at 0")
    return round(stamp * NANOSECONDS)


def header(stamp: float, frame_id: str) -> Any:
    """Create a `std_msgs/Header`."""
    seconds, rest = divmod(nanoseconds(stamp), NANOSECONDS)
    time = message("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
    return message("std_msgs/msg/Header", stamp=time, frame_id=frame_id)


def nanoseconds_of(header: Any) -> int:
    """Stamp of a header [ns]."""
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def set_nanoseconds(header: Any, stamp: int) -> None:
    """Set the stamp of a header [ns], clipped to the range of ROS."""
    whole, rest = divmod(min(max(stamp, 0), END_NS - 1), NANOSECONDS)
    header.stamp.sec, header.stamp.nanosec = whole, rest


def seconds(msg: Any) -> float:
    """Stamp of a message with a header [s]."""
    stamp = msg.header.stamp
    return stamp.sec + stamp.nanosec / NANOSECONDS
