"""Names of nodes and topics as ROS 2 has them, and as DDS does."""

from __future__ import annotations

import re

from circumspect.errors import InputError

TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
LONGEST = 248
"""Characters of a topic's name; DDS allows 256, prefix included."""


def node_path(namespace: str, name: str) -> str:
    """The full name of a node: "/robot1/circumspect".

    Args:
        namespace: Such as "/robot1"; "" and "/" for none.
        name: Such as "circumspect".

    Raises:
        InputError: ROS does not allow the name.
    """
    if not TOKEN.fullmatch(name):
        raise InputError(
            f"a node can not be called {name[:40]!r}; names are letters, digits and _, and do not "
            "begin with a digit"
        )
    return _checked(f"/{namespace.strip('/')}/{name}".replace("//", "/"))


def topic_path(name: str, node: str) -> str:
    """The full name of a topic.

    Args:
        name: Absolute ("/odom"), in the node's namespace ("odom"), or below the node ("~/model").
        node: The node's full name.

    Raises:
        InputError: ROS does not allow the name.
    """
    if name.startswith("/"):
        return _checked(name)
    if name.startswith("~/"):
        return _checked(f"{node}/{name[2:]}")
    return _checked(f"{node.rsplit('/', 1)[0]}/{name}")


def dds_topic(topic: str) -> str:
    """A topic's name in DDS: "rt/odom" (design.ros2.org, Topic and Service names)."""
    return f"rt{topic}"


def _checked(path: str) -> str:
    tokens = path.removeprefix("/").split("/")
    if len(path) > LONGEST or not all(TOKEN.fullmatch(token) for token in tokens):
        raise InputError(
            f"ROS allows no name such as {path[:60]!r}; names are letters, digits and _ between "
            "slashes, and do not begin with a digit"
        )
    return path
