"""A ROS 2 node from its first message to its last answer, whatever carries the messages."""

from __future__ import annotations

from circumspect.classification import Classifier
from circumspect.cli.node_screen import NodeScreen, going_on
from circumspect.ros.middleware import Middleware
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode


def run_node(
    middleware: Middleware,
    settings: NodeSettings,
    where: str,
    as_json: bool = False,
    seconds: float | None = None,
) -> None:
    """Work until Ctrl-C, SIGTERM or the end of the time; the middleware is closed in any case.

    Args:
        middleware: Carries the messages.
        settings: Of the node.
        where: How others are reached, in words.
        as_json: Answers are JSON lines.
        seconds: The time [s]; None for no end.

    Raises:
        InputError: A parameter makes no sense.
        WeightsError: The classifier can not be loaded.
    """
    screen = NodeScreen(as_json)
    try:
        classifier = Classifier.load(settings.weights or None)
        node = RecognitionNode(middleware, settings, classifier, (screen,))
    except BaseException:
        middleware.close()
        screen.end()
        raise
    screen.begin(settings, where)
    try:
        with going_on(seconds) as goes_on:
            node.spin(goes_on)
    except KeyboardInterrupt:
        pass  # the usual end of a node
    finally:
        node.close()
        screen.end()
