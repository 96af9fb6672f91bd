"""Starts the node: `ros2 launch circumspect_ros circumspect.launch.py params:=robot.yaml`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """One node and its parameter file."""
    usual = Path(get_package_share_directory("circumspect_ros")) / "config" / "circumspect.yaml"
    params = DeclareLaunchArgument("params", default_value=str(usual))
    node = Node(
        package="circumspect_ros",
        executable="circumspect",
        name="circumspect",
        output="screen",
        parameters=[LaunchConfiguration("params")],
    )
    return LaunchDescription([params, node])
