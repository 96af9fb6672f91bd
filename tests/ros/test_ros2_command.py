"""`circumspect ros2` as a process, with a robot on the wire."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from graph_reader import GraphReader
from orbiting_robot import DEPTH, OrbitingRobot

from circumspect.cli.main import main
from circumspect.ros.dds_middleware import DdsMiddleware
from circumspect.ros.dds_settings import DdsSettings


def begun(dds: DdsSettings, folder: Path, *flags: str) -> tuple[subprocess.Popen[str], Path]:
    words = [sys.executable, "-m", "circumspect", "ros2", "--local", "--depth", DEPTH]
    environ = {**os.environ, "ROS_DOMAIN_ID": str(dds.domain)}
    out = folder / "out.txt"
    with out.open("w") as stream:
        process = subprocess.Popen(
            [*words, "--rate", "0", "--queue", "50", *flags], stdout=stream,
            stderr=subprocess.PIPE, text=True, env=environ,
        )  # fmt: skip
    return process, out


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "sigterm"])
def test_labels_until_it_is_told_to_end(dds: DdsSettings, tmp_path: Path, how: int) -> None:
    air = DdsMiddleware(dds, "")
    robot = OrbitingRobot(air)
    process, out = begun(dds, tmp_path, *(["--json"] if how == signal.SIGINT else []))
    robot.stand()
    until = time.monotonic() + 60
    number = 0
    while not out.read_text().count("\n") and time.monotonic() < until:
        robot.drive(number % 20, late=4.0 * (number // 20))
        number += 1
        time.sleep(0.2)
    process.send_signal(how)
    _, told = process.communicate(timeout=60)
    air.close()
    assert process.returncode == 0, told
    lines = out.read_text().splitlines()
    if how == signal.SIGINT:
        answers: list[dict[str, Any]] = [json.loads(line) for line in lines]
        assert answers[-1]["label"] in answers[-1]["probabilities"]
        assert isinstance(answers[-1]["in_distribution"], bool)
    else:
        assert " coverage " in lines[0]
    assert "circumspect: the answer: " in told
    assert "Traceback" not in told
    assert all(len(line) <= 160 for line in told.splitlines())


def test_ros2_node_list_shows_it(dds: DdsSettings, tmp_path: Path) -> None:
    """With the topics of the tables in docs/ros2.md: depth, odometry, /tf, info and /tf_static
    (each twice, latched and not) and three commands; four of its own, /diagnostics and /tf."""
    air = DdsMiddleware(dds, "")
    graph = GraphReader(dds.domain)
    process, _ = begun(dds, tmp_path, "--name", "looker", "--namespace", "/robot")
    try:
        graph.wait_for("/robot/looker", (10, 6))
    finally:
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
        air.close()
    assert process.returncode == 0, told


def test_it_ends_by_itself_and_says_what_is_missing(
    dds: DdsSettings, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(dds.domain))
    assert main(["ros2", "--local", "--duration", "4.5", "--driver", "orbbec"]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert "/circumspect listens to /camera/depth/image_raw" in told.err
    assert "nobody publishes depth images on /camera/depth/image_raw" in told.err


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--mount", "1", "2"], "mount takes 5 numbers"),
        (["--depth", "a b"], "ROS allows no name"),
        (["--name", "9"], "a node can not be called '9'"),
        (["--model", "/nowhere.onnx"], "/nowhere.onnx"),
        (["--box", *"000000"], "is flat"),
        (["--intrinsics", *"0000"], "focal lengths must be positive"),
        (["--mount", "0", "0", "0", "0", "90"], "give finite values and a tilt within 90"),
        (["--intrinsics", "500", "500", "320", "240", "--size", "nan", "480"], "whole pixels"),
        (["--duration", "nan"], "--duration nan: give seconds above 0"),
        (["--duration", "-5"], "--duration -5: give seconds above 0"),
    ],
)
def test_flags_that_make_no_sense(
    dds: DdsSettings, monkeypatch: pytest.MonkeyPatch, capsys, flags: list[str], said: str
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(dds.domain))
    assert main(["ros2", "--local", *flags]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1


def test_a_domain_that_is_none(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    assert main(["ros2"]) == 2
    assert "ROS_DOMAIN_ID is 'many'" in capsys.readouterr().err


def test_a_flag_that_switches_off_says_so(tmp_path: Path, capsys) -> None:
    def helped(*words: str) -> str:
        with pytest.raises(SystemExit):
            main(["ros2", *words, "--help"])
        return " ".join(capsys.readouterr().out.replace("│", " ").split())

    assert "--no-transforms Do not tell on /tf" in helped()
    assert "--no-autostart Wait until told to begin" in helped()
    waits = tmp_path / "waits.yaml"
    waits.write_text("circumspect:\n  ros__parameters:\n    autostart: false\n")
    assert "--autostart Whether to begin at once" in helped("--params-file", str(waits))
