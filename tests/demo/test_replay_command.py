from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.cli.commands.replay import Replay
from circumspect.cli.main import main
from circumspect.cli.recording_flags import RecordingFlags
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, read_cloud
from circumspect.sensing import DepthNoise
from circumspect.simulation import Orbit, Scene, SimulatedCamera

CHAIR = make_furniture("chair", 7)
LOW, HIGH = CHAIR.vertices_xyz.min(axis=0), CHAIR.vertices_xyz.max(axis=0)
LOW = LOW + np.array([-0.02, -0.02, 0.03])
HIGH = HIGH + np.array([0.02, 0.02, 0.02])
# The recording's own world lies askew, as those of real recordings do.
T_WORLD_MAP = RigidTransform.from_components(
    [0.4, -1.0, 2.0], Rotation.from_euler("x", 115, degrees=True)
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight frames round a simulated chair, written as a 7-Scenes folder."""
    folder = tmp_path_factory.mktemp("recording")
    camera = PinholeCamera(640, 480, 570.3, 570.3, 320.0, 240.0)
    orbit = Orbit.around(CHAIR, camera)
    simulated = SimulatedCamera(
        Scene.with_object(CHAIR), orbit.stations(8).__next__, camera, DepthNoise()
    )
    for index, frame in enumerate(simulated.frames(8)):
        stem = folder / f"frame-{2 * index:06d}"
        millimetres = np.rint(np.nan_to_num(frame.depth) * 1000).astype(np.uint16)
        Image.fromarray(millimetres).save(f"{stem}.depth.png")
        np.savetxt(f"{stem}.pose.txt", (T_WORLD_MAP * frame.pose).as_matrix())
    np.savetxt(folder / "camera-intrinsics.txt", [[570.3, 0, 320], [0, 570.3, 240], [0, 0, 1]])
    np.savetxt(folder / "gravity-direction.txt", T_WORLD_MAP.rotation.apply([0, 0, -1]))
    return folder


def corners(frame: str) -> tuple[float, ...]:
    """The chair's box, in the recording's world or in the map that replay makes of it."""
    world = T_WORLD_MAP.apply(np.array([LOW, HIGH]))
    if frame == "map":
        # Turned back about the x axis; the origin stays that of the world.
        world = T_WORLD_MAP.rotation.inv().apply(world)
    return tuple(world.ravel().tolist())


def test_the_object_in_the_box_is_modelled_in_place_and_classified(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clouds = []
    for frame in ("world", "map"):
        out = tmp_path / frame
        reading = RecordingFlags(corners(frame), box_frame=frame)
        command = Replay(recording, reading, out=out, json=True)
        assert command.run() == 0
        record = json.loads(capsys.readouterr().out)
        assert (record["label"], record["frames"], record["skipped"]) == ("chair", 8, 0)
        clouds.append(read_cloud(out / "model.ply").points_xyz)
    np.testing.assert_allclose(clouds[0], clouds[1], atol=1e-9)
    origin = T_WORLD_MAP.rotation.inv().apply(T_WORLD_MAP.translation)
    distance, _ = cKDTree(CHAIR.sampled(60_000).points_xyz).query(clouds[0] - origin)
    assert np.median(distance) < 0.004
    assert np.quantile(distance, 0.99) < 0.02


def test_every_second_frame(recording: Path, tmp_path: Path) -> None:
    Replay(recording, RecordingFlags(corners("world"), every=2), out=tmp_path).run()
    assert json.loads((tmp_path / "result.json").read_text())["frames"] == 4
    again = ["replay", "--config", str(tmp_path / "config.toml"), "--out", str(tmp_path / "again")]
    assert main(again) == 0
    assert json.loads((tmp_path / "again" / "result.json").read_text())["frames"] == 4


def test_the_answer_fits_the_terminal(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for every, count in ((1, ", 8 frames,"), (1000, ", 1 frame,")):
        reading = RecordingFlags(corners("world"), poses="hidden", every=every)
        assert Replay(recording, reading, out=tmp_path / "run").run() == 0
        lines = capsys.readouterr().out.splitlines()
        assert count in " ".join(lines)
        assert max(len(line) for line in lines if not line.startswith("All of it")) <= 80


def test_a_camera_that_was_lost_is_reported_after_the_answer(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The camera stands; from frame 4 on a wall fills known free space."""
    copy = tmp_path / "copy"
    shutil.copytree(recording, copy)
    wall = np.full((480, 640), 600, np.uint16)
    first, *images = sorted(copy.glob("*.depth.png"))
    for image in images[:3]:
        shutil.copy(first, image)
    for image in images[3:]:
        Image.fromarray(wall).save(image)
    reading = RecordingFlags(corners("world"), poses="hidden")
    assert Replay(copy, reading, out=tmp_path / "run").run() == 0
    text = "The camera was lost from frame 4 on; the answer is of what it saw until then."
    assert text in " ".join(capsys.readouterr().out.split())
    assert json.loads((tmp_path / "run" / "result.json").read_text())["lost_from"] == 4


def test_views_without_overlap_are_not_placed(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Views 45° apart do not overlap: hidden poses cannot be found."""
    reading = RecordingFlags(corners("world"), poses="hidden")
    assert Replay(recording, reading, out=tmp_path / "run").run() == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Frames that are not part of it: the pose is not reliable (7)" in text


def test_frames_without_depth_are_counted_in_the_answer(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(recording, copy)
    blank = np.zeros((480, 640), np.uint16)
    for number in (4, 8):
        Image.fromarray(blank).save(copy / f"frame-{number:06d}.depth.png")
    assert Replay(copy, RecordingFlags(corners("world")), out=tmp_path / "run").run() == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "Frames that are not part of it: no depth in the frame (2)." in printed


def test_an_empty_box_ends_without_an_answer(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reading = RecordingFlags((50.0, 50.0, 50.0, 51.0, 51.0, 51.0))
    assert Replay(recording, reading, out=tmp_path, json=True).run() == 1
    assert json.loads(capsys.readouterr().out)["label"] is None
    assert Replay(recording, reading, out=tmp_path).run() == 1
    assert "No answer after 8 frames: no object in view" in capsys.readouterr().out


def test_skipped_frames_are_reported(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(recording, copy)
    (copy / "frame-000004.depth.png").write_bytes(b"")
    Replay(copy, RecordingFlags(corners("world")), out=tmp_path / "run", json=True).run()
    printed = capsys.readouterr()
    assert json.loads(printed.out)["skipped"] == 1
    kept = json.loads((tmp_path / "run" / "replay.json").read_text())
    assert list(kept["skipped"]) == ["frame-000004.depth.png"]
    assert kept["measured"] == {}, "nothing was found by registration"
    (report,) = [line for line in printed.err.splitlines() if "left out" in line]
    assert report.startswith("circumspect: frame-000004.depth.png left out: ")
    assert report.endswith("(no picture of the formats PNG)"), "one line, however long"


def test_invalid_boxes_and_folders_are_refused(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="flat"):
        Replay(recording, RecordingFlags((0.0,) * 6), out=tmp_path / "run").run()
    reading = RecordingFlags((0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="no such recording"):
        Replay(tmp_path / "nowhere", reading, out=tmp_path / "run").run()
    assert not (tmp_path / "run").exists()


def test_the_kitchen_s_chair_and_table(data_folder: Path, tmp_path: Path) -> None:
    """Boxes found by eye in a plan view; see the docs on real frames."""
    boxes = {
        "chair": (-1.45, 1.30, -1.46, -0.97, 2.03, -0.60),
        "table": (-1.02, 1.10, -1.44, 1.24, 2.12, -0.74),
    }
    for name, box in boxes.items():
        out = tmp_path / name
        reading = RecordingFlags(box, box_frame="map", every=12)
        Replay(data_folder / "redkitchen", reading, out=out).run()
        assert json.loads((out / "result.json").read_text())["label"] == name
