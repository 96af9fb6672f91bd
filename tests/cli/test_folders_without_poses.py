"""`replay --first-pose`: folders of frames without recorded poses."""

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
from circumspect.sensing import FloorProblem

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
    """X Y Z PAN TILT of the camera on its robot, where the map of the run starts."""
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
    result = json.loads((tmp_path / "run/result.json").read_text())
    config = json.loads((tmp_path / "run/config.json").read_text())
    assert result["frames"] == FRAMES
    assert config["first_pose"] == [float(value) for value in first_pose(live)]
    assert config["segmentation"] == {"kind": "ground"}
    found, known = (read_tum(path / "run/trajectory.txt") for path in (tmp_path, live))
    away = found.T_map_camera.translation - known.T_map_camera.translation
    assert np.linalg.norm(away, axis=1).max() < 0.02, "the same path, without wheels"
    sizes = [np.ptp(read_cloud(p / "run/model.ply").points_xyz, axis=0) for p in (tmp_path, live)]
    np.testing.assert_allclose(sizes[0], sizes[1], atol=0.06)


def test_a_box_is_in_the_map_frame(live: Path, tmp_path: Path) -> None:
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
def test_a_folder_without_poses_needs_a_first_pose(
    live: Path, kind: str, poses: tuple[str, ...], capsys: pytest.CaptureFixture
) -> None:
    box = ["--box", "0", "0", "0", "1", "1", "1"]
    assert main(["replay", str(live / kind), *box, *poses]) == 2
    stderr = capsys.readouterr().err
    assert "contains no poses" in stderr
    assert "--first-pose X Y Z PAN TILT" in stderr
    assert stderr.count("\n") == 1


VIEW = ["--first-pose", "0", "0", "1", "0", "30"]


@pytest.mark.parametrize(
    ("recording", "flags", "error"),
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
def test_conflicting_flags_are_refused(
    live: Path, recording: str, flags: list[str], error: str, capsys: pytest.CaptureFixture
) -> None:
    assert main(["replay", str(live / recording), *flags]) == 2
    assert error in capsys.readouterr().err


@pytest.mark.parametrize(
    ("height", "tilt", "problem"),
    [
        (0, 0, ""),
        (0, 6, FloorProblem.BELOW_FLOOR),
        (0, -6, FloorProblem.NO_FLOOR),
        (-0.3, 0, FloorProblem.BELOW_FLOOR),
        (0.3, 0, FloorProblem.NO_FLOOR),
    ],
)
def test_a_first_pose_that_the_floor_contradicts_gets_no_answer(
    live: Path,
    tmp_path: Path,
    height: float,
    tilt: float,
    problem: str,
    capsys: pytest.CaptureFixture,
) -> None:
    """Otherwise the floor itself, or half an object, would be classified."""
    x, y, z, pan, down = (float(value) for value in first_pose(live))
    view = [f"{value:.4f}" for value in (x, y, z + height, pan, down + tilt)]
    out = ["--out", str(tmp_path / "run"), "--every", "6"]
    code = main(["replay", str(live / "tum"), "--first-pose", *view, *out])
    assert code == (1 if problem else 0)
    answer = " ".join(capsys.readouterr().out.split())
    assert answer.startswith("No answer after 2 frames: " if problem else "Result: chair (")
    assert problem in answer


@pytest.mark.parametrize("kind", ["tum", "seven"])
def test_hidden_poses_are_accepted_for_a_folder_without_poses(
    live: Path, tmp_path: Path, kind: str
) -> None:
    flags = ["--first-pose", *first_pose(live), "--poses", "hidden", "--every", "6"]
    assert main(["replay", str(live / kind), *flags, "--out", str(tmp_path), "--json"]) == 0
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["frames"] == 2
    assert result["label"] is not None


def test_points_beyond_the_range_of_the_camera_are_no_object(
    live: Path, tmp_path: Path, capsys
) -> None:
    flags = ["--first-pose", *first_pose(live), "--every", "6", "--out", str(tmp_path / "run")]
    replayed = ["replay", str(live / "seven"), *flags]
    assert main([*replayed, "--depth-range", "0.3", "0.7"]) == 1
    assert capsys.readouterr().out.startswith("No answer after 2 frames: ")
    assert json.loads((tmp_path / "run/config.json").read_text())["depth_range"] == [0.3, 0.7]
    assert main([*replayed, "--depth-range", "2", "1"]) == 2
    assert "minimum and the maximum [m], not 2 and 1" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["tum", "seven"])
def test_an_unreadable_recording_keeps_the_earlier_run(
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
