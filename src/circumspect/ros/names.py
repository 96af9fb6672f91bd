"""Names of nodes and topics in ROS 2 and DDS."""

from __future__ import annotations

import re

from circumspect.errors import InputError

TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
MAX_TOPIC_LENGTH = 248
"""Maximum length of a topic name; DDS allows 256 including the prefix."""


def node_path(namespace: str, name: str) -> str:
    """The full name of a node: "/robot1/circumspect".

    Args:
        namespace: Namespace such as "/robot1"; "" and "/" for none.
        name: Name such as "circumspect".

    Raises:
        InputError: The name is invalid in ROS.
    """
    if not TOKEN.fullmatch(name):
        raise InputError(
            f"{name[:40]!r} is not a valid node name; names are letters, digits and _, and do not "
            "start with a digit"
        )
    return _checked(f"/{namespace.strip('/')}/{name}".replace("//", "/"))


def topic_path(name: str, node: str) -> str:
    """The full name of a topic.

    Args:
        name: Absolute ("/odom"), in the node's namespace ("odom"), or below the node ("~/model").
        node: The node's full name.

    Raises:
        InputError: The name is invalid in ROS.
    """
    if name.startswith("/"):
        return _checked(name)
    if name.startswith("~/"):
        return _checked(f"{node}/{name[2:]}")
    return _checked(f"{node.rsplit('/', 1)[0]}/{name}")


def dds_topic(topic: str) -> str:
    """The DDS name of a topic: "rt/odom" (design.ros2.org, Topic and Service names)."""
    return f"rt{topic}"


def _checked(path: str) -> str:
    tokens = path.removeprefix("/").split("/")
    if len(path) > MAX_TOPIC_LENGTH or not all(TOKEN.fullmatch(token) for token in tokens):
        raise InputError(
            f"{path[:60]!r} is not a valid ROS name; names are letters, digits and _ between "
            "slashes, and do not start with a digit"
        )
    return path
