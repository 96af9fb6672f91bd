from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from circumspect.errors import InputError
from circumspect.recording import SevenScenesFolder
from circumspect.recording.frame_folder import _shortest_turn

DOWN = np.array([0.1, 0.9, 0.42])


def write_depth(path: Path, value: int, size: tuple[int, int] = (640, 480)) -> None:
    depth = np.full(size[::-1], value, np.uint16)
    depth[0, 0], depth[0, 1] = 0, 65535
    Image.fromarray(depth).save(path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three frames; the first also in colour."""
    for number in (0, 2, 4):
        stem = tmp_path / f"frame-{number:06d}"
        write_depth(Path(f"{stem}.depth.png"), 1000 + number)
        pose = np.eye(4)
        pose[:3, 3] = [0.1 * number, 0.0, 1.0]
        np.savetxt(f"{stem}.pose.txt", pose)
    red = np.zeros((480, 640, 3), np.uint8)
    red[..., 0] = 200
    Image.fromarray(red).save(tmp_path / "frame-000000.color.png")
    np.savetxt(tmp_path / "camera-intrinsics.txt", [[500, 0, 320], [0, 510, 240], [0, 0, 1]])
    np.savetxt(tmp_path / "gravity-direction.txt", DOWN)
    return tmp_path


def test_frames_come_in_order_with_depth_pose_colour_and_stamp(folder: Path) -> None:
    frames = list(SevenScenesFolder(folder))
    assert [round(float(f.depth[9, 9]), 3) for f in frames] == [1.0, 1.002, 1.004]
    assert np.isnan(frames[0].depth[0, :2]).all()
    assert [f.stamp for f in frames] == [0.0, 2 / 30, 4 / 30]
    assert (frames[0].camera.fx, frames[0].camera.fy, frames[0].camera.cx) == (500, 510, 320)
    assert frames[0].colour is not None
    assert (frames[0].colour[..., 0] == 200).all()
    assert frames[1].colour is None


def test_poses_are_turned_so_that_gravity_points_down(folder: Path) -> None:
    scene = SevenScenesFolder(folder)
    np.testing.assert_allclose(
        scene.T_map_world.apply(DOWN / np.linalg.norm(DOWN)), [0, 0, -1], atol=1e-12
    )
    frame = list(scene)[1]
    np.testing.assert_allclose(
        frame.pose.translation, scene.T_map_world.apply([0.2, 0.0, 1.0]), atol=1e-12
    )
    assert np.linalg.norm(frame.pose.translation) == pytest.approx(np.hypot(0.2, 1.0))


@given(
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
    | st.sampled_from([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1e-9, 0.0, -1.0)])
)
def test_levelling_takes_the_shortest_rotation(up: tuple[float, float, float]) -> None:
    unit = np.array(up) / np.linalg.norm(up)
    turn = _shortest_turn(unit)
    np.testing.assert_allclose(turn.apply(unit), [0, 0, 1], atol=1e-7)
    assert turn.magnitude() == pytest.approx(np.arccos(np.clip(unit[2], -1, 1)), abs=1e-6)


def test_a_rounded_last_row_of_a_pose_is_accepted(folder: Path) -> None:
    pose = np.eye(4)
    pose[3] = [1e-7, -5e-7, 0.0, 1 - 1e-7]
    np.savetxt(folder / "frame-000000.pose.txt", pose)
    scene = SevenScenesFolder(folder)
    assert len(list(scene)) == 3
    assert not scene.skipped


def test_every_second_frame(folder: Path) -> None:
    assert len(SevenScenesFolder(folder, every=2)) == 2
    assert [round(float(f.depth[9, 9]), 3) for f in SevenScenesFolder(folder, every=2)] == [
        1.0,
        1.004,
    ]
    with pytest.raises(InputError, match="every 0"):
        SevenScenesFolder(folder, every=0)


def test_default_intrinsics_and_gravity_are_those_of_the_data_set(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / "camera-intrinsics.txt").unlink()
    (folder / "gravity-direction.txt").unlink()
    with caplog.at_level(logging.WARNING):
        frame = next(iter(SevenScenesFolder(folder)))
    assert (frame.camera.fx, frame.camera.cx, frame.camera.cy) == (585, 320, 240)
    np.testing.assert_allclose(frame.pose.translation, [0, 0, 1])
    assert "gravity-direction.txt" in caplog.text


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def remove(path: Path) -> None:
    path.unlink()


def wrong_size(path: Path) -> None:
    write_depth(path, 1000, size=(200, 100))


def eight_bit(path: Path) -> None:
    Image.fromarray(np.zeros((480, 640), np.uint8)).save(path)


def not_an_image(path: Path) -> None:
    path.write_bytes(b"depth")


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def no_numbers(path: Path) -> None:
    path.write_text("one two three")


def binary(path: Path) -> None:
    path.write_bytes(bytes(range(256)))


def too_few(path: Path) -> None:
    np.savetxt(path, np.eye(3))


def nan_pose(path: Path) -> None:
    np.savetxt(path, np.where(np.eye(4) > 0, np.nan, 0))


def scaled_pose(path: Path) -> None:
    np.savetxt(path, np.diag([2.0, 2.0, 2.0, 1.0]))


def mirrored_pose(path: Path) -> None:
    np.savetxt(path, np.diag([-1.0, 1.0, 1.0, 1.0]))


@pytest.mark.parametrize(
    ("suffix", "spoil"),
    [
        *[("depth.png", f) for f in (truncate, wrong_size, eight_bit, not_an_image, a_folder)],
        *[
            ("pose.txt", f)
            for f in (remove, no_numbers, binary, too_few, nan_pose, scaled_pose, mirrored_pose)
        ],
    ],
)
def test_one_bad_frame_is_skipped_and_reported(
    folder: Path, suffix: str, spoil, caplog: pytest.LogCaptureFixture
) -> None:
    spoil(folder / f"frame-000002.{suffix}")
    scene = SevenScenesFolder(folder)
    with caplog.at_level(logging.WARNING):
        frames = list(scene)
    assert [round(float(f.depth[9, 9]), 3) for f in frames] == [1.0, 1.004]
    assert list(scene.skipped) == ["frame-000002.depth.png"]
    assert f"frame-000002.{suffix}" in scene.skipped["frame-000002.depth.png"]
    assert f"frame-000002.{suffix}" in caplog.text
    assert "\n" not in scene.skipped["frame-000002.depth.png"]


def test_a_bad_colour_image_keeps_the_frame_without_colour(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    truncate(folder / "frame-000000.color.png")
    with caplog.at_level(logging.WARNING):
        frames = list(SevenScenesFolder(folder))
    assert len(frames) == 3
    assert frames[0].colour is None
    assert "frame-000000.color.png" in caplog.text


def test_a_folder_without_readable_frames_is_refused_with_the_first_reason(folder: Path) -> None:
    for file in folder.glob("*.pose.txt"):
        file.unlink()
    with pytest.raises(InputError, match=r"none of 3 frames.*frame-000000\.pose\.txt"):
        list(SevenScenesFolder(folder))


def test_missing_or_empty_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        SevenScenesFolder(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"contains no frame-\*\.depth\.png"):
        SevenScenesFolder(tmp_path)


@pytest.mark.parametrize(
    "matrix", [np.zeros((3, 3)), np.eye(4), [[500, 0, 320], [0, 510, 240], [0, 0, 2]]]
)
def test_broken_intrinsics(folder: Path, matrix: np.ndarray) -> None:
    np.savetxt(folder / "camera-intrinsics.txt", matrix)
    with pytest.raises(InputError, match=r"camera-intrinsics\.txt"):
        SevenScenesFolder(folder)


@pytest.mark.parametrize("direction", [[0, 0, 0], [0, np.inf, 0], [1, 2]])
def test_broken_gravity(folder: Path, direction: list[float]) -> None:
    np.savetxt(folder / "gravity-direction.txt", direction)
    with pytest.raises(InputError, match=r"gravity-direction\.txt"):
        SevenScenesFolder(folder)


def test_real_kitchen_has_a_level_floor_and_a_table(data_folder: Path) -> None:
    scene = SevenScenesFolder(data_folder / "redkitchen", every=25)
    points = np.concatenate([f.points_map((f.depth < 3) & f.valid)[::7] for f in scene])
    assert not scene.skipped
    table = (
        (points[:, 0] > -0.8) & (points[:, 0] < 1.1) & (points[:, 1] > 1.3) & (points[:, 1] < 1.9)
    )
    heights = points[table, 2]
    top = np.abs(heights - np.median(heights)) < 0.05
    assert top.mean() > 0.6
    x, y, z = points[table][top].T
    slopes = np.linalg.lstsq(np.column_stack([x, y, np.ones(len(x))]), z, rcond=None)[0][:2]
    assert np.abs(slopes).max() < 0.03


def test_poses_may_be_hidden(folder: Path) -> None:
    hidden = SevenScenesFolder(folder, poses=False)
    assert [frame.T_map_camera for frame in hidden] == [None, None, None]
