"""`circumspect ros2`."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.config_file import ConfigFlag, early_value
from circumspect.cli.dashboard_page import PageFlags
from circumspect.errors import InputError
from circumspect.ros.node_settings import NodeSettings

if TYPE_CHECKING:
    from circumspect.cli.watched_replay import NodeWatch


@dataclass(frozen=True)
class Ros2:
    """Run a ROS 2 node that classifies the object in front of a robot's camera.

    $ circumspect ros2 --driver realsense --odometry /odom
    $ circumspect ros2 --depth /camera/depth/image_rect_raw --mount 0.1 0 0.9 0 30
    $ circumspect ros2 --params-file robot.yaml --json
    $ circumspect ros2 --driver realsense --viewer

    Topics, frames and errors: docs/ros2.md. Needs no ROS. Ctrl-C ends the node.
    """

    params_file: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """ROS 2 parameter file, with the names of the flags and _ for -. Flags override it."""
    config: ConfigFlag = None
    local: bool = False
    """Communicate only with nodes on this machine, like ROS_LOCALHOST_ONLY=1."""
    duration: Annotated[float | None, tyro.conf.arg(metavar="SECONDS")] = None
    """Time after which the node ends [s]."""
    json: bool = False
    """Print one JSON line on standard output at each change of the answer, and nothing else."""
    viewer: bool = False
    """Show sensor data and answers in the browser, and start and stop the node there."""
    page: PageFlags = field(default_factory=PageFlags)
    """Address of the dashboard."""
    node: NodeSettings = field(default_factory=NodeSettings)
    """Parameters of the node."""

    def __post_init__(self) -> None:
        if self.duration is not None and not 0 < self.duration < math.inf:
            raise InputError(f"--duration {self.duration:g}: give seconds above 0")

    def run(self) -> int:
        """Run the node until Ctrl-C, SIGTERM or the end of --duration."""
        import os

        from circumspect.cli.node_run import run_node
        from circumspect.ros.dds_middleware import DdsMiddleware
        from circumspect.ros.dds_settings import DdsSettings

        dds = DdsSettings.from_environment(os.environ)
        if self.local:
            dds = dds.local_only()
        with contextlib.ExitStack() as pages:
            watch = self._watch(pages) if self.viewer else None
            middleware = DdsMiddleware(dds, self.node.node)
            run_node(middleware, self.node, dds.description, self.json, self.duration, watch)
        return 0

    def _watch(self, pages: contextlib.ExitStack) -> NodeWatch:
        from circumspect.classification import Classifier
        from circumspect.cli.watched_replay import NodeWatch

        classifier = Classifier.load(self.node.model)
        return NodeWatch(pages.enter_context(self.page.opened(classifier)))


def preset(words: Sequence[str], values: Mapping[str, Any]) -> dict[str, Any]:
    """The values of flags from a parameter file, overridden by other values.

    Args:
        words: The flags.
        values: Values of flags that override those of the file.
    """

    def early(name: str) -> Any:
        given = early_value(words, name)
        return values.get(name) if given is None else given

    file = early("params_file")
    if file is None:
        return dict(values)
    from circumspect.ros.node_settings import read_parameters

    node = NodeSettings()
    called = NodeSettings(early("name") or node.name, early("namespace") or node.namespace)
    parameters = read_parameters(file, called.node)
    node = NodeSettings.from_parameters(parameters)
    known = {name: getattr(node, name) for name in parameters if hasattr(node, name)}
    return {**known, **values}
