"""Helpers for tests of the node."""

from __future__ import annotations

import time
from typing import Any

from orbiting_robot import DEPTH, MemoryBus

from circumspect.recording.ros_types import message
from circumspect.ros.middleware import COMMANDS
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.output_messages import EMPTY
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.ros.wire_messages import serialized

SETTINGS = NodeSettings(depth=DEPTH, rate=0.0, queue=50)


def worked_off(node: RecognitionNode) -> list[Any]:
    steps = []
    while (step := node.work(timeout=0.02)) is not None:
        steps.append(step)
    return steps


def send(bus: MemoryBus, topic: str, kind: str = EMPTY) -> None:
    empty = message(EMPTY, structure_needs_at_least_one_member=0)
    bus.advertise(topic, kind, COMMANDS)(serialized(kind, empty))


def values(node: RecognitionNode) -> dict[str, Any]:
    return node.health.status(node.running, None, 0).values


def status(bus: MemoryBus, text: str, seconds: float = 6.0) -> Any:
    """The first diagnostic status whose message contains the text."""
    until = time.monotonic() + seconds
    messages: list[str] = []
    while time.monotonic() < until:
        for msg in bus.received("/diagnostics"):
            messages.append(msg.status[0].message)
            if text in msg.status[0].message:
                return msg.status[0]
        time.sleep(0.05)
    raise AssertionError(f"nobody said {text!r}, but {sorted(set(messages))}")
