"""Parameters of the node, declared with rclpy."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor

from circumspect.ros.node_settings import NodeSettings

DECLARED_BY_ROS = ("use_sim_time", "start_type_description_service")
"""Parameters that rclpy declares itself, in addition to qos_overrides."""


def read_settings(node: Any) -> NodeSettings:
    """Create the settings from the parameters of a node.

    Args:
        node: A `rclpy.node.Node` that declares its overrides automatically, so that a misspelt name
            is detected.

    Raises:
        InputError: A name is unknown, or a value is invalid.
    """
    given = {
        name: _plain(parameter.value)
        for name, parameter in node.get_parameters_by_prefix("").items()
        if name not in DECLARED_BY_ROS and not name.startswith("qos_overrides")
    }
    for name in ("name", "namespace"):
        given.pop(name, None)  # ROS has its own way to name nodes
    place = {"name": node.get_name(), "namespace": node.get_namespace()}
    settings = NodeSettings.from_parameters({**given, **place})
    _declare_rest(node, settings)
    return settings


def _declare_rest(node: Any, settings: NodeSettings) -> None:
    """Declare the parameters that were not set."""
    for field in fields(settings):
        if field.name in ("name", "namespace") or node.has_parameter(field.name):
            continue
        value = getattr(settings, field.name)
        default = list(value) if isinstance(value, tuple) else value
        # An empty list has no type in ROS.
        node.declare_parameter(
            field.name, default, ParameterDescriptor(dynamic_typing=default == [])
        )


def _plain(value: Any) -> Any:
    """Arrays of numbers as lists."""
    return value if isinstance(value, str | bool | int | float) else list(value)
