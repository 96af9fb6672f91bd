"""`circumspect watch`: files of the RealSense SDK, in the hand and on a base."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realsense_files import recorded

from circumspect.cli.commands.watch import until_ctrl_c
from circumspect.cli.main import main
from circumspect.errors import MissingExtraError
from circumspect.recording import open_recording
from circumspect.recording.realsense_camera import realsense_sdk

FLAGS = ["chair-3", "--start", "40", "--seed", "5", "--frames", "8", "--frame-interval", "1"]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the camera of a scan saw, as the SDK records it."""
    try:
        sdk = realsense_sdk()
    except MissingExtraError:
        pytest.skip("the extra realsense is not installed")
    folder = tmp_path_factory.mktemp("watch")
    words = ["--record", str(folder / "run.mcap"), "--out", str(folder / "run"), "--json"]
    assert main(["scan", *FLAGS, *words]) == 0
    frames = list(open_recording(folder / "run.mcap"))
    mount = frames[0].T_base_camera
    assert mount is not None
    ahead = mount.rotation.as_matrix()[:, 2]
    angles = np.degrees([np.arctan2(ahead[1], ahead[0]), -np.arcsin(ahead[2])])
    view = [f"{value:.5f}" for value in (*mount.translation, *angles)]
    (folder / "mount.json").write_text(json.dumps(view))
    depths = [frame.depth for frame in frames]
    return recorded(folder / "run.db3", sdk, depths, frames[0].camera, interval=1.0)


def watched(file: Path, out: Path, *flags: str) -> int:
    return main(["watch", "--camera", str(file), *flags, "--out", str(out)])


@pytest.mark.parametrize("place", ["hand", "mount"])
def test_a_chair_is_named_in_the_hand_and_on_a_base(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture, place: str
) -> None:
    view = json.loads((file.parent / "mount.json").read_text())
    flags = [] if place == "hand" else [f"--{place}", *view]
    assert watched(file, tmp_path, *flags, "--json") == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert lines[-1]["label"] == "chair"
    assert lines[-1]["device"] == "Intel RealSense D455"
    assert lines[-1]["frames"] == 8
    config = json.loads((tmp_path / "config.json").read_text())
    assert config["depth_range"] == [0.6, 6.0]


def test_sentences_and_every_second_frame(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    view = json.loads((file.parent / "mount.json").read_text())
    flags = ["--every", "2", "--depth-range", "0.5", "3", "--first-pose", *view]
    assert watched(file, tmp_path, *flags) in (0, 1)
    out, err = capsys.readouterr()
    assert "Intel RealSense D455, 0.5 to 3 m; Ctrl-C ends the run" in err
    assert "4 frames" in out


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--camera", "gone.db3"], "gone.db3: no such file"),
        (["--every", "0"], "--every 0"),
        (["--duration", "0"], "--duration 0"),
        (["--mount", *"00100", "--first-pose", *"00100"], "--mount is for a camera on a base"),
    ],
)
def test_errors_are_one_line(
    flags: list[str], words: str, capsys: pytest.CaptureFixture, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    try:
        realsense_sdk()
    except MissingExtraError:
        pytest.skip("the extra realsense is not installed")
    monkeypatch.chdir(tmp_path)
    assert main(["watch", *flags]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


def test_without_a_floor_the_remedy_is_named(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    wall = [np.full((48, 64), 2.0, np.float32)] * 3
    from circumspect.geometry import PinholeCamera

    camera = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
    path = recorded(tmp_path / "wall.db3", realsense_sdk(), wall, camera)
    assert watched(path, tmp_path / "out") == 2
    assert "no floor is seen in the first frames" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_ctrl_c_ends_the_frames_once_and_then_interrupts() -> None:
    before: Any = signal.getsignal(signal.SIGINT)
    with until_ctrl_c(None) as goes_on:
        assert goes_on()
        signal.raise_signal(signal.SIGINT)
        assert not goes_on()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
    with until_ctrl_c(0.01) as goes_on:
        time.sleep(0.03)
        assert not goes_on()
