"""The node's parameters, declared with rclpy."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor

from circumspect.ros.node_settings import NodeSettings

OF_ROS = ("use_sim_time", "start_type_description_service")
"""Parameters that rclpy declares for itself; those that begin with qos_overrides are its, too."""


def read_settings(node: Any) -> NodeSettings:
    """The settings that a node's parameters say.

    Args:
        node: A `rclpy.node.Node` that declares its overrides by itself, so that a misspelt name
            is seen.

    Raises:
        InputError: A name is not known, or a value makes no sense.
    """
    given = {
        name: _plain(parameter.value)
        for name, parameter in node.get_parameters_by_prefix("").items()
        if name not in OF_ROS and not name.startswith("qos_overrides")
    }
    for name in ("name", "namespace"):
        given.pop(name, None)  # ROS has its own way to name nodes
    place = {"name": node.get_name(), "namespace": node.get_namespace()}
    settings = NodeSettings.from_parameters({**given, **place})
    _declare_rest(node, settings)
    return settings


def _declare_rest(node: Any, settings: NodeSettings) -> None:
    """Let others see the parameters that nobody set."""
    for field in fields(settings):
        if field.name in ("name", "namespace") or node.has_parameter(field.name):
            continue
        value = getattr(settings, field.name)
        told = list(value) if isinstance(value, tuple) else value
        # An empty list has no type in ROS.
        node.declare_parameter(field.name, told, ParameterDescriptor(dynamic_typing=told == []))


def _plain(value: Any) -> Any:
    """Arrays of numbers as lists."""
    return value if isinstance(value, str | bool | int | float) else list(value)
