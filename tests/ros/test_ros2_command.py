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


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "sigterm"])
def test_answers_are_printed_until_a_signal(dds: DdsSettings, tmp_path: Path, end: int) -> None:
    air = DdsMiddleware(dds, "")
    robot = OrbitingRobot(air)
    process, out = begun(dds, tmp_path, *(["--json"] if end == signal.SIGINT else []))
    robot.publish_mount()
    until = time.monotonic() + 60
    number = 0
    while not out.read_text().count("\n") and time.monotonic() < until:
        robot.publish_frame(number % 20, late=4.0 * (number // 20))
        number += 1
        time.sleep(0.2)
    process.send_signal(end)
    _, output = process.communicate(timeout=60)
    air.close()
    assert process.returncode == 0, output
    lines = out.read_text().splitlines()
    if end == signal.SIGINT:
        answers: list[dict[str, Any]] = [json.loads(line) for line in lines]
        assert answers[-1]["label"] in answers[-1]["probabilities"]
        assert isinstance(answers[-1]["in_distribution"], bool)
    else:
        assert " coverage " in lines[0]
    assert "circumspect: the answer: " in output
    assert "Traceback" not in output
    assert all(len(line) <= 160 for line in output.splitlines())


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
        _, output = process.communicate(timeout=60)
        air.close()
    assert process.returncode == 0, output


def test_it_ends_after_its_duration_and_reports_what_is_missing(
    dds: DdsSettings, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(dds.domain))
    assert main(["ros2", "--local", "--duration", "4.5", "--driver", "orbbec"]) == 0
    output = capsys.readouterr()
    assert output.out == ""
    assert "/circumspect listens to /camera/depth/image_raw" in output.err
    assert "nobody publishes depth images on /camera/depth/image_raw" in output.err


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--mount", "1", "2"], "mount takes 5 numbers"),
        (["--depth", "a b"], "is not a valid ROS name"),
        (["--name", "9"], "'9' is not a valid node name"),
        (["--model", "/nowhere.onnx"], "/nowhere.onnx"),
        (["--box", *"000000"], "is flat"),
        (["--intrinsics", *"0000"], "focal lengths must be positive"),
        (["--mount", "0", "0", "0", "0", "90"], "give finite values and a tilt within 90"),
        (["--intrinsics", "500", "500", "320", "240", "--size", "nan", "480"], "whole pixels"),
        (["--duration", "nan"], "--duration nan: give seconds above 0"),
        (["--duration", "-5"], "--duration -5: give seconds above 0"),
    ],
)
def test_invalid_flags_are_refused(
    dds: DdsSettings, monkeypatch: pytest.MonkeyPatch, capsys, flags: list[str], said: str
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(dds.domain))
    assert main(["ros2", "--local", *flags]) == 2
    output = capsys.readouterr().err
    assert said in output
    assert output.count("\n") == 1


def test_an_invalid_domain_is_refused(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    assert main(["ros2"]) == 2
    assert "ROS_DOMAIN_ID is 'many'" in capsys.readouterr().err


def test_help_describes_flags_that_switch_off(tmp_path: Path, capsys) -> None:
    def helped(*words: str) -> str:
        with pytest.raises(SystemExit):
            main(["ros2", *words, "--help"])
        return " ".join(capsys.readouterr().out.replace("│", " ").split())

    assert "--no-transforms Do not publish that transform" in helped()
    assert "--no-autostart Wait for a message on ~/start" in helped()
    waits = tmp_path / "waits.yaml"
    waits.write_text("circumspect:\n  ros__parameters:\n    autostart: false\n")
    assert "--autostart, --no-autostart Whether to start immediately" in helped(
        "--params-file", str(waits)
    )
