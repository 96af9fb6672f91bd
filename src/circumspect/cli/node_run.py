"""A ROS 2 node from its first message to its last answer, whatever carries the messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.classification import Classifier
from circumspect.cli.node_screen import NodeScreen, going_on
from circumspect.ros.middleware import Middleware
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode

if TYPE_CHECKING:
    from circumspect.cli.watched_node import NodeWatch


def run_node(
    middleware: Middleware,
    settings: NodeSettings,
    where: str,
    as_json: bool = False,
    seconds: float | None = None,
    watch: NodeWatch | None = None,
) -> None:
    """Work until Ctrl-C, SIGTERM or the end of the time; the middleware is closed in any case.

    Args:
        middleware: Carries the messages.
        settings: Of the node.
        where: How others are reached, in words.
        as_json: Answers are JSON lines.
        seconds: The time [s]; None for no end.
        watch: Shows the node in the browser, where wanted.

    Raises:
        InputError: A parameter makes no sense.
        WeightsError: The classifier can not be loaded.
    """
    screen = NodeScreen(as_json)
    try:
        classifier = Classifier.load(settings.model)
        observers = (screen,) if watch is None else (screen, watch)
        node = RecognitionNode(middleware, settings, classifier, observers)
    except BaseException:
        middleware.close()
        screen.end()
        raise
    try:
        screen.begin(settings, where)
        if watch is not None:
            watch.begin(node)
        with going_on(seconds) as goes_on:
            node.spin(goes_on)
    except KeyboardInterrupt:
        pass  # the usual end of a node
    finally:
        node.close()
        screen.end()
