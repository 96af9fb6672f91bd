"""`circumspect ros2`."""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from circumspect.cli.dashboard_page import PageFlags
from circumspect.errors import InputError
from circumspect.ros.node_settings import NodeSettings

if TYPE_CHECKING:
    from circumspect.cli.watched_node import NodeWatch


@dataclass(frozen=True)
class Ros2:
    """A ROS 2 node, without a ROS installation: names what a robot's camera sees.

    $ circumspect ros2 --driver realsense --odometry /odom
    $ circumspect ros2 --depth /camera/depth/image_rect_raw --mount 0.1 0 0.9 0 30
    $ circumspect ros2 --params-file robot.yaml --json
    $ circumspect ros2 --driver realsense --viewer

    Topics, frames and faults: docs/ros2.md. Ctrl-C ends it.
    """

    params_file: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """A ROS 2 parameter file: the same names with _ for -. Flags win over it."""
    local: bool = False
    """Talk to nodes on this machine only, as ROS_LOCALHOST_ONLY=1 does."""
    duration: Annotated[float | None, tyro.conf.arg(metavar="SECONDS")] = None
    """End after this time."""
    json: bool = False
    """One JSON line on standard output at each change of the answer, nothing else there."""
    viewer: bool = False
    """Show in the browser what the node sees and says, and start and stop it there."""
    page: Annotated[PageFlags, tyro.conf.arg(name="")] = field(default_factory=PageFlags)
    """Where the dashboard is shown."""
    node: Annotated[NodeSettings, tyro.conf.arg(name="")] = field(default_factory=NodeSettings)
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
            dds = dds.on_this_machine()
        with contextlib.ExitStack() as pages:
            watch = self._watch(pages) if self.viewer else None
            middleware = DdsMiddleware(dds, self.node.node)
            run_node(middleware, self.node, dds.where, self.json, self.duration, watch)
        return 0

    def _watch(self, pages: contextlib.ExitStack) -> NodeWatch:
        from circumspect.classification import Classifier
        from circumspect.cli.watched_node import NodeWatch

        classifier = Classifier.load(self.node.model)
        return NodeWatch(pages.enter_context(self.page.opened(classifier)))


def preset(words: Sequence[str]) -> Ros2:
    """What a parameter file that the flags name puts in the place of the defaults."""
    first = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    first.add_argument("--params-file", "--params_file", nargs="?")
    for flag in ("--name", "--namespace"):
        # What stands there in vain is tyro's to tell.
        first.add_argument(flag, nargs="?")
    early, _ = first.parse_known_args(list(words))
    node = NodeSettings()
    if early.params_file is not None:
        from circumspect.ros.parameter_file import read_parameters

        called = NodeSettings(early.name or node.name, early.namespace or node.namespace)
        node = NodeSettings.from_parameters(read_parameters(early.params_file, called.node))
    return Ros2(node=node)
