"""`ros2 run circumspect_ros circumspect`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import rclpy
from rclpy.signals import SignalHandlerOptions

from circumspect.cli.node_run import run_node
from circumspect.errors import CircumspectError
from circumspect_ros.parameters import read_settings
from circumspect_ros.rclpy_middleware import RclpyMiddleware


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM.

    Args:
        arguments: Arguments of ROS; None for those of the process.

    Returns:
        Exit code: 0, or 2 after a known error.
    """
    # The last answer is published after Ctrl-C, so rclpy must not shut down by itself.
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    try:
        return _run()
    except CircumspectError as error:
        sys.stderr.write(f"circumspect: {error}\n")
        return 2
    finally:
        rclpy.try_shutdown()


def _run() -> int:
    ros_node = rclpy.create_node(
        "circumspect", automatically_declare_parameters_from_overrides=True
    )
    settings = read_settings(ros_node)
    run_node(RclpyMiddleware(ros_node), settings, "by rclpy")
    return 0
