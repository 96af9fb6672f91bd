"""Starts the node, and RViz if asked for.

    ros2 launch circumspect_ros circumspect.launch.py driver:=orbbec odometry:=/odom rviz:=true

An argument that is not given keeps its value from the parameter file.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "circumspect_ros"
PARAMETERS = {
    "driver": (str, "camera driver that sets depth topic and range: realsense, orbbec, openni"),
    "depth": (str, "topic of the depth images"),
    "info": (str, "topic of their CameraInfo"),
    "odometry": (str, "topic of the odometry"),
    "odom_frame": (str, "frame of the odometry"),
    "base_frame": (str, "frame of the robot"),
    "rate": (float, "frames per second that are processed; 0 for all"),
    "model": (str, "shipped classifier or ONNX file"),
    "autostart": (bool, "process frames at once, without ~/start"),
}
"""Parameters of the node that are arguments too: type and description."""
SHOWN = ("model", "path", "next_view", "detections")
"""Topics below the node's name that the RViz configuration displays."""


def generate_launch_description() -> LaunchDescription:
    """Arguments, and a function that starts what they ask for."""
    usual = Path(get_package_share_directory(PACKAGE)) / "config" / "circumspect.yaml"
    declared = [
        DeclareLaunchArgument("params", default_value=str(usual), description="parameter file"),
        DeclareLaunchArgument("name", default_value="circumspect", description="node name"),
        DeclareLaunchArgument("namespace", default_value="", description="node namespace"),
        DeclareLaunchArgument("rviz", default_value="false", description="start RViz as well"),
    ]
    for name, (_, description) in PARAMETERS.items():
        declared.append(DeclareLaunchArgument(name, default_value="", description=description))
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """The node, and RViz with `rviz:=true`."""
    name, namespace = _value(context, "name"), _value(context, "namespace")
    given = {
        parameter: _typed(_value(context, parameter), kind)
        for parameter, (kind, _) in PARAMETERS.items()
        if _value(context, parameter)
    }
    started = [
        Node(
            package=PACKAGE,
            executable="circumspect",
            name=name,
            namespace=namespace,
            output="screen",
            parameters=[_value(context, "params"), given],
        )
    ]
    if _typed(_value(context, "rviz"), bool):
        parts = [part for part in (namespace.strip("/"), name) if part]
        started.append(_rviz("/" + "/".join(parts)))
    return started


def _rviz(node: str) -> Node:
    """RViz on the topics of a node, whatever its name and namespace."""
    shown = Path(get_package_share_directory(PACKAGE)) / "rviz" / "circumspect.rviz"
    return Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(shown)],
        remappings=[(f"/circumspect/{topic}", f"{node}/{topic}") for topic in SHOWN],
    )


def _value(context: LaunchContext, name: str) -> str:
    return LaunchConfiguration(name).perform(context)


def _typed(text: str, kind: type) -> Any:
    if kind is bool:
        return text.lower() in ("true", "1", "yes", "on")
    return kind(text)
