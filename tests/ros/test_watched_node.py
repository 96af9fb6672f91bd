"""A node in the dashboard: it is shown, started, stopped and begun anew there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from orbiting_robot import DEPTH, MemoryBus, OrbitingRobot
from test_ros2_command import begun

from circumspect.classification import Classifier
from circumspect.cli.watched_node import NodeWatch
from circumspect.errors import InputError
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.viewer import Dashboard

SETTINGS = NodeSettings(depth=DEPTH, rate=0.0, queue=50)
EMPTY = {"/paths/registration", "/paths/odometry"}
"""What a stage shows before anything is known: paths of no length."""


def drawn(dashboard: Dashboard) -> set[str]:
    """Names of what the stage shows of a run."""
    return set(dashboard.stage._nodes)


def test_what_a_node_knows_is_put_before_the_onlooker() -> None:
    # It averages over more grids at a stop than in a frame.
    classifier, bus = Classifier.load("modelnet10", threads=1), MemoryBus()
    with Dashboard(classifier, port=0) as dashboard:
        put: list[Any] = []
        dashboard.put = put.append  # type: ignore[method-assign]
        watch = NodeWatch(dashboard)
        node = RecognitionNode(bus, SETTINGS, classifier, (watch,))
        watch.begin(node)
        assert put.pop()().count == 0
        watch.on_status(node.health.status(True, "nobody publishes", 0))
        assert "nobody publishes" in put.pop()().news
        robot = OrbitingRobot(bus)
        robot.stand()
        for number in range(8):
            robot.drive(number)
        while node.work(timeout=0.02) is not None:
            pass
        shown = put[-1]()
        assert shown.count == len(shown.path_xyz) == len(shown.odometry_xyz) == 8
        assert shown.row["label"] == "chair"
        assert len(shown.thing.points_xyz) > 1000
        assert shown.images.depth is node.frame.depth
        assert node.target is not None

        dashboard.show(shown)
        assert {"/object", "/camera", "/robot", "/grid/outline"} <= drawn(dashboard)
        node.command("reset")
        node.work(timeout=0.02)
        assert put[-1]().count == 0
        dashboard.show(put[-1]())
        assert drawn(dashboard) == EMPTY
        robot.drive(8)
        node.work(timeout=0.02)
        assert put[-1]().count == 1
        hurried = put[-1]().row["probabilities"]
        node.command("stop")
        node.work(timeout=0.02)
        assert put[-1]().row["probabilities"] != hurried
        status = node.health.status(False, None, 0)
        assert f"{max(put[-1]().row['probabilities'].values()):.3f}" in str(status.values)
        assert node.ended == "the node is stopped"
        with pytest.raises(InputError, match="no command 'drive'"):
            node.command("drive")
        node.close()


def test_a_page_of_nothing_is_shown() -> None:
    from circumspect.viewer.shown import Shown

    with Dashboard(Classifier.load(threads=1), port=0) as dashboard:
        dashboard.show(Shown((), 0))


def test_the_command_tells_where_the_page_is(dds: DdsSettings, tmp_path: Path) -> None:
    flags = ("--viewer", "--viewer-port", "0", "--duration", "1")
    process, _ = begun(dds, tmp_path, *flags)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 0, told
    assert re.search(r"the dashboard is at http://127\.0\.0\.1:\d+; Ctrl-C ends it", told)
    assert "Traceback" not in told
