"""Time as ROS has it."""

from __future__ import annotations

from typing import Any

from circumspect.errors import InputError
from circumspect.recording.ros_types import message

NANOSECONDS = 1_000_000_000
LAST = 2**31 * NANOSECONDS
"""Seconds are 32 bits, signed."""


def nanoseconds(stamp: float) -> int:
    """Nanoseconds of a stamp [s].

    Raises:
        InputError: Before 0, or later than 32 bits of seconds can tell.
    """
    if not 0 <= stamp * NANOSECONDS < LAST - 0.5:
        raise InputError(f"the stamp {stamp} s can not be recorded; ROS counts seconds from 0")
    return round(stamp * NANOSECONDS)


def header(stamp: float, frame_id: str) -> Any:
    """A `std_msgs/Header`."""
    seconds, rest = divmod(nanoseconds(stamp), NANOSECONDS)
    time = message("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
    return message("std_msgs/msg/Header", stamp=time, frame_id=frame_id)


def nanoseconds_of(header: Any) -> int:
    """Stamp [ns] of a header."""
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def set_nanoseconds(header: Any, stamp: int) -> None:
    """Set the stamp of a header [ns]; what ROS can not hold becomes the nearest that it can."""
    whole, rest = divmod(min(max(stamp, 0), LAST - 1), NANOSECONDS)
    header.stamp.sec, header.stamp.nanosec = whole, rest


def seconds(told: Any) -> float:
    """Stamp [s] of a message with a header."""
    stamp = told.header.stamp
    return stamp.sec + stamp.nanosec / NANOSECONDS
