"""`replay --first-pose`: folders of frames whose poses nobody recorded."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from circumspect.cli.main import main
from circumspect.geometry import read_cloud, read_tum
from circumspect.recording import open_recording
from circumspect.sensing import FloorFault

FRAMES = 12
FLAGS = ["chair-3", "--start", "40", "--seed", "5", "--frames", str(FRAMES)]


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with its recording, and its frames as folders in both layouts, without any pose."""
    path = tmp_path_factory.mktemp("live")
    recorded = ["--record", str(path / "run.mcap"), "--out", str(path / "run"), "--json"]
    assert main(["scan", *FLAGS, *recorded]) == 0
    lines = []
    for kind in ("tum", "seven"):
        (path / kind).mkdir()
    for number, frame in enumerate(open_recording(path / "run.mcap")):
        depth = np.nan_to_num(frame.depth)
        Image.fromarray((5000 * depth).astype(np.uint16)).save(path / f"tum/{number}.png")
        seven = path / f"seven/frame-{15 * number:06d}.depth.png"
        Image.fromarray((1000 * depth).astype(np.uint16)).save(seven)
        lines.append(f"{frame.stamp:.4f} {number}.png")
        c = frame.camera
        matrix = [[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]]
    (path / "tum/depth.txt").write_text("\n".join(lines))
    for kind in ("tum", "seven"):
        np.savetxt(path / kind / "camera-intrinsics.txt", matrix)
    return path


def first_pose(live: Path) -> list[str]:
    """X Y Z PAN TILT of the camera on its robot, which is where the run's map begins."""
    T = next(iter(open_recording(live / "run.mcap"))).T_base_camera
    assert T is not None
    x, y, z = T.rotation.as_matrix()[:, 2]
    view = [*T.translation, np.degrees(np.arctan2(y, x)), np.degrees(-np.arcsin(z))]
    return [f"{value:.6f}" for value in view]


@pytest.mark.parametrize("kind", ["tum", "seven"])
def test_the_object_is_modelled_from_the_first_pose_on(
    live: Path, tmp_path: Path, kind: str
) -> None:
    out = ["--out", str(tmp_path / "run"), "--json"]
    assert main(["replay", str(live / kind), "--first-pose", *first_pose(live), *out]) == 0
    told = json.loads((tmp_path / "run/result.json").read_text())
    config = json.loads((tmp_path / "run/config.json").read_text())
    assert told["frames"] == FRAMES
    assert config["first_pose"] == [float(value) for value in first_pose(live)]
    assert config["segmentation"] == {"kind": "ground"}
    found, known = (read_tum(path / "run/trajectory.txt") for path in (tmp_path, live))
    away = found.T_map_camera.translation - known.T_map_camera.translation
    assert np.linalg.norm(away, axis=1).max() < 0.02, "the same path, without wheels"
    sizes = [np.ptp(read_cloud(p / "run/model.ply").points_xyz, axis=0) for p in (tmp_path, live)]
    np.testing.assert_allclose(sizes[0], sizes[1], atol=0.06)


def test_a_box_is_one_in_the_map(live: Path, tmp_path: Path) -> None:
    points = read_cloud(live / "run/model.ply").points_xyz
    corners = np.concatenate([points.min(axis=0) - 0.02, points.max(axis=0) + 0.02])
    box = ["--box", *[f"{value:.3f}" for value in corners]]
    flags = ["--first-pose", *first_pose(live), *box, "--out", str(tmp_path / "run"), "--json"]
    assert main(["replay", str(live / "seven"), *flags]) == 0
    config = json.loads((tmp_path / "run/config.json").read_text())
    assert config["box_frame"] == "map"
    inside = read_cloud(tmp_path / "run/model.ply").points_xyz
    assert (inside > corners[:3] - 0.02).all()
    assert (inside < corners[3:] + 0.02).all()


@pytest.mark.parametrize("kind", ["tum", "seven"])
@pytest.mark.parametrize("poses", [(), ("--poses", "given")])
def test_without_it_such_a_folder_is_refused(
    live: Path, kind: str, poses: tuple[str, ...], capsys: pytest.CaptureFixture
) -> None:
    box = ["--box", "0", "0", "0", "1", "1", "1"]
    assert main(["replay", str(live / kind), *box, *poses]) == 2
    told = capsys.readouterr().err
    assert "holds no poses" in told
    assert "--first-pose X Y Z PAN TILT" in told
    assert told.count("\n") == 1


VIEW = ["--first-pose", "0", "0", "1", "0", "30"]


@pytest.mark.parametrize(
    ("recording", "flags", "told"),
    [
        ("run.mcap", VIEW, "--first-pose is for folders"),
        ("tum", [*VIEW, "--poses", "given"], "give one"),
        ("tum", [*VIEW[:-1], "90"], "a tilt within 90°"),
        ("tum", [*VIEW[:-1], "nan"], "give finite values"),
        ("tum", ["--first-pose", "0", "0", "-1", "0", "30"], "a camera -1 m above the floor"),
        ("tum", ["--first-pose", "0", "0", "1200", "0", "30"], "give Z in metres"),
        ("tum", ["--first-pose", "0", "0", "nan", "0", "30"], "give Z in metres"),
    ],
)
def test_what_does_not_go_together_is_told(
    live: Path, recording: str, flags: list[str], told: str, capsys: pytest.CaptureFixture
) -> None:
    assert main(["replay", str(live / recording), *flags]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("height", "tilt", "told"),
    [
        (0, 0, ""),
        (0, 6, FloorFault.BELOW_FLOOR),
        (0, -6, FloorFault.NO_FLOOR),
        (-0.3, 0, FloorFault.BELOW_FLOOR),
        (0.3, 0, FloorFault.NO_FLOOR),
    ],
)
def test_a_first_pose_that_the_floor_contradicts_gets_no_answer(
    live: Path, tmp_path: Path, height: float, tilt: float, told: str, capsys: pytest.CaptureFixture
) -> None:
    """Else the floor itself, or half an object, is named as if nothing was wrong."""
    x, y, z, pan, down = (float(value) for value in first_pose(live))
    view = [f"{value:.4f}" for value in (x, y, z + height, pan, down + tilt)]
    out = ["--out", str(tmp_path / "run"), "--every", "6"]
    code = main(["replay", str(live / "tum"), "--first-pose", *view, *out])
    assert code == (1 if told else 0)
    answer = " ".join(capsys.readouterr().out.split())
    assert answer.startswith("No answer after 2 frames: " if told else "Result: chair (")
    assert told in answer


@pytest.mark.parametrize("kind", ["tum", "seven"])
def test_poses_may_be_called_hidden_where_none_are(live: Path, tmp_path: Path, kind: str) -> None:
    flags = ["--first-pose", *first_pose(live), "--poses", "hidden", "--every", "6"]
    assert main(["replay", str(live / kind), *flags, "--out", str(tmp_path), "--json"]) == 0
    told = json.loads((tmp_path / "result.json").read_text())
    assert told["frames"] == 2
    assert told["label"] is not None


def test_what_is_beyond_the_cameras_range_is_no_object(live: Path, tmp_path: Path, capsys) -> None:
    flags = ["--first-pose", *first_pose(live), "--every", "6", "--out", str(tmp_path / "run")]
    replayed = ["replay", str(live / "seven"), *flags]
    assert main([*replayed, "--depth-range", "0.3", "0.7"]) == 1
    assert capsys.readouterr().out.startswith("No answer after 2 frames: ")
    assert json.loads((tmp_path / "run/config.json").read_text())["depth_range"] == [0.3, 0.7]
    assert main([*replayed, "--depth-range", "2", "1"]) == 2
    assert "nearest and the farthest [m], not 2 and 1" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["tum", "seven"])
def test_a_recording_of_which_nothing_can_be_read_costs_no_earlier_run(
    live: Path, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture
) -> None:
    shutil.copytree(live / kind, tmp_path / "frames")
    run = ["--first-pose", *first_pose(live), "--out", str(tmp_path / "run"), "--json"]
    assert main(["replay", str(tmp_path / "frames"), *run]) == 0
    before = {path: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    for image in (tmp_path / "frames").glob("*.png"):
        image.write_bytes(b"no image")
    capsys.readouterr()
    assert main(["replay", str(tmp_path / "frames"), *run]) == 2
    assert "can be read" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in (tmp_path / "run").iterdir()} == before
