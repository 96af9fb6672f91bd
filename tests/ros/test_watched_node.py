"""A node in the dashboard: shown, stopped and reset there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from orbiting_robot import DEPTH, MemoryBus, OrbitingRobot
from test_ros2_command import begun

from circumspect.classification import Classifier
from circumspect.cli.watched_replay import NodeWatch
from circumspect.errors import InputError
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.viewer import Dashboard

SETTINGS = NodeSettings(depth=DEPTH, rate=0.0, queue=50)
EMPTY = {"/paths/registration", "/paths/odometry"}
"""What the stage shows before the first frame: paths of no length."""


def drawn(dashboard: Dashboard) -> set[str]:
    """Names of what the stage shows of a run."""
    return set(dashboard.stage._nodes)


def test_the_dashboard_shows_the_state_of_the_node() -> None:
    # It averages over more grids at a stop than in a frame.
    classifier, bus = Classifier.load("modelnet10", threads=1), MemoryBus()
    with Dashboard(classifier, port=0) as dashboard:
        published: list[Any] = []
        dashboard.put = published.append  # type: ignore[method-assign]
        watch = NodeWatch(dashboard)
        node = RecognitionNode(bus, SETTINGS, classifier, (watch,))
        watch.begin(node)
        assert published.pop()().count == 0
        watch.on_status(node.health.status(True, "nobody publishes", 0))
        assert "nobody publishes" in published.pop()().message
        robot = OrbitingRobot(bus)
        robot.publish_mount()
        for number in range(8):
            robot.publish_frame(number)
        while node.work(timeout=0.02) is not None:
            pass
        shown = published[-1]()
        assert shown.count == len(shown.path_xyz) == len(shown.odometry_xyz) == 8
        assert shown.row["label"] == "chair"
        assert len(shown.object_snapshot.points_xyz) > 1000
        assert shown.images.depth is node.frame.depth
        assert node.target is not None

        dashboard.show(shown)
        assert {"/object", "/camera", "/robot", "/grid/outline"} <= drawn(dashboard)
        node.command("reset")
        node.work(timeout=0.02)
        assert published[-1]().count == 0
        dashboard.show(published[-1]())
        assert drawn(dashboard) == EMPTY
        robot.publish_frame(8)
        node.work(timeout=0.02)
        assert published[-1]().count == 1
        provisional = published[-1]().row["probabilities"]
        node.command("stop")
        node.work(timeout=0.02)
        assert published[-1]().row["probabilities"] != provisional
        status = node.health.status(False, None, 0)
        assert f"{max(published[-1]().row['probabilities'].values()):.3f}" in str(status.values)
        assert node.ended == "the node is stopped"
        with pytest.raises(InputError, match="no command 'drive'"):
            node.command("drive")
        node.close()


def test_an_empty_page_is_shown() -> None:
    from circumspect.viewer.dashboard_state import DashboardState

    with Dashboard(Classifier.load(threads=1), port=0) as dashboard:
        dashboard.show(DashboardState((), 0))


def test_the_command_prints_the_address_of_the_dashboard(dds: DdsSettings, tmp_path: Path) -> None:
    flags = ("--viewer", "--viewer-port", "0", "--duration", "1")
    process, _ = begun(dds, tmp_path, *flags)
    _, output = process.communicate(timeout=60)
    assert process.returncode == 0, output
    assert re.search(r"the dashboard is at http://127\.0\.0\.1:\d+; Ctrl-C ends it", output)
    assert "Traceback" not in output
