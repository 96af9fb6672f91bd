"""Runs a ROS 2 node on any middleware."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.classification import Classifier
from circumspect.cli.node_screen import NodeScreen, going_on
from circumspect.ros.middleware import Middleware
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode

if TYPE_CHECKING:
    from circumspect.cli.watched_replay import NodeWatch


def run_node(
    middleware: Middleware,
    settings: NodeSettings,
    where: str,
    as_json: bool = False,
    seconds: float | None = None,
    watch: NodeWatch | None = None,
) -> None:
    """Run a node until Ctrl-C, SIGTERM or the end of the time, then close the middleware.

    Args:
        middleware: Transport of the messages.
        settings: Settings of the node.
        where: Description of the network, for the terminal.
        as_json: Print answers as JSON lines.
        seconds: The time [s]; None means no limit.
        watch: Shows the node in the browser; None means no dashboard.

    Raises:
        InputError: A parameter is invalid.
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
        pass  # The usual end of a node.
    finally:
        node.close()
        screen.end()
