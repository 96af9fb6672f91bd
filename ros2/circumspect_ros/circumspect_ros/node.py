"""`ros2 run circumspect_ros circumspect`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import rclpy
from rclpy.signals import SignalHandlerOptions

from circumspect.classification import Classifier
from circumspect.cli.node_screen import NodeScreen, going_on
from circumspect.errors import CircumspectError
from circumspect.ros.recognition_node import RecognitionNode
from circumspect_ros.parameters import read_settings
from circumspect_ros.rclpy_middleware import RclpyMiddleware


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM.

    Args:
        arguments: Those of ROS; None means those of the process.

    Returns:
        Exit code: 0, or 2 after a known fault.
    """
    # The last answer is told after Ctrl-C, so rclpy must not shut down by itself.
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
    middleware = RclpyMiddleware(ros_node)
    try:
        settings = read_settings(ros_node)
        screen = NodeScreen(as_json=False)
        classifier = Classifier.load(settings.weights or None)
        node = RecognitionNode(middleware, settings, classifier, (screen,))
    except BaseException:
        middleware.close()
        raise
    screen.begin(settings, "by rclpy")
    try:
        with going_on(None) as goes_on:
            node.spin(goes_on)
    except KeyboardInterrupt:
        pass  # the usual end of a node
    finally:
        node.close()
        screen.end()
    return 0
