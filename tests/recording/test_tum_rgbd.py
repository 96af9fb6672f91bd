from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import Trajectory, write_tum
from circumspect.recording import SevenScenesFolder, TumRgbdFolder, open_recording
from circumspect.recording.tum_rgbd import pose_at

STAMPS = 1305031102.16 + np.array([0.0, 0.033, 0.066])


def write_depth(path: Path, value: int, size: tuple[int, int] = (640, 480)) -> None:
    depth = np.full(size[::-1], value, np.uint16)
    depth[0, 0], depth[0, 1] = 0, 65535
    Image.fromarray(depth).save(path)


def path_at(stamps: np.ndarray) -> Trajectory:
    """Along x at 1 m/s while turning about z at 1 rad/s."""
    times = stamps - STAMPS[0]
    places = np.column_stack([times, 0 * times, 0 * times + 1])
    turns = Rotation.from_rotvec(np.outer(times, [0, 0, 1.0]))
    return Trajectory(stamps, RigidTransform.from_components(places, turns))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three frames with colour, and poses at 100 Hz."""
    path = tmp_path / "rgbd_dataset_freiburg2_desk"
    (path / "depth").mkdir(parents=True)
    (path / "rgb").mkdir()
    lines: dict[str, list[str]] = {"depth": [], "rgb": []}
    for index, stamp in enumerate(STAMPS):
        write_depth(path / "depth" / f"{stamp:.6f}.png", 5000 + 500 * index)
        lines["depth"].append(f"{stamp:.6f} depth/{stamp:.6f}.png")
        Image.new("RGB", (640, 480), (60 * index, 0, 0)).save(path / "rgb" / f"{index}.png")
        lines["rgb"].append(f"{stamp + 0.011:.6f} rgb/{index}.png")
    for name, entries in lines.items():
        (path / f"{name}.txt").write_text("\n".join([f"# {name} images", *entries, ""]))
    write_tum(path / "groundtruth.txt", path_at(STAMPS[0] + np.arange(-0.05, 0.2, 0.01)))
    return path


def test_frames_come_in_order_with_depth_pose_colour_and_stamp(folder: Path) -> None:
    frames = list(TumRgbdFolder(folder))
    assert [round(float(f.depth[9, 9]), 4) for f in frames] == [1.0, 1.1, 1.2]
    assert np.isnan(frames[0].depth[0, :2]).all()
    np.testing.assert_allclose([f.stamp for f in frames], STAMPS, atol=1e-6)
    assert [int(f.colour[5, 5, 0]) for f in frames] == [0, 60, 120]
    for frame, stamp in zip(frames, STAMPS, strict=True):
        expected = path_at(np.array([stamp])).T_map_camera[0]
        np.testing.assert_allclose(frame.pose.as_matrix(), expected.as_matrix(), atol=1e-5)


@pytest.mark.parametrize(
    ("name", "focal"),
    [
        ("rgbd_dataset_freiburg1_xyz", (517.3, 516.5, 318.6, 255.3)),
        ("freiburg3_teddy", (535.4, 539.2, 320.1, 247.6)),
        ("fr2_desk", (520.9, 521.0, 325.1, 249.7)),
        ("my_own", (525.0, 525.0, 319.5, 239.5)),
        ("freiburg12", (525.0, 525.0, 319.5, 239.5)),
    ],
)
def test_the_folder_name_gives_the_camera(folder: Path, name: str, focal: tuple) -> None:
    renamed = folder.rename(folder.with_name(name))
    camera = next(iter(TumRgbdFolder(renamed))).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == focal


def test_intrinsics_in_the_folder_take_precedence(folder: Path) -> None:
    np.savetxt(folder / "camera-intrinsics.txt", [[500, 0, 320], [0, 510, 240], [0, 0, 1]])
    camera = next(iter(TumRgbdFolder(folder))).camera
    assert (camera.fx, camera.fy) == (500, 510)


def test_an_unknown_camera_is_reported(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        TumRgbdFolder(folder.rename(folder.with_name("mine")))
    assert "the name contains no camera" in caplog.text


def test_poses_may_be_hidden(folder: Path) -> None:
    hidden = list(TumRgbdFolder(folder, poses=False))
    assert [frame.T_map_camera for frame in hidden] == [None, None, None]
    (folder / "groundtruth.txt").unlink()
    scene = TumRgbdFolder(folder)
    assert scene.truth is None
    assert [frame.T_map_camera for frame in scene] == [None, None, None]


def test_poses_are_turned_so_that_gravity_points_down(folder: Path) -> None:
    level = [frame.pose.as_matrix() for frame in TumRgbdFolder(folder)]
    np.savetxt(folder / "gravity-direction.txt", [0.0, 2.0, 0.0])
    scene = TumRgbdFolder(folder)
    turn = scene.T_map_world
    np.testing.assert_allclose(turn.apply([0.0, 1.0, 0.0]), [0, 0, -1], atol=1e-12)
    for frame, before in zip(scene, level, strict=True):
        np.testing.assert_allclose(frame.pose.as_matrix(), turn.as_matrix() @ before, atol=1e-12)
    np.testing.assert_allclose(scene.truth.positions_xyz[5], turn.apply([0, 0, 1]), atol=1e-6)
    hidden = TumRgbdFolder(folder, poses=False)
    assert hidden.T_map_world.as_matrix() == pytest.approx(np.eye(4)), "no pose brings its world"


def test_every_second_frame(folder: Path) -> None:
    assert len(TumRgbdFolder(folder, every=2)) == 2
    depths = [round(float(f.depth[9, 9]), 4) for f in TumRgbdFolder(folder, every=2)]
    assert depths == [1.0, 1.2]
    with pytest.raises(InputError, match="every 0"):
        TumRgbdFolder(folder, every=0)


def test_unsorted_lists_are_sorted(folder: Path) -> None:
    lines = (folder / "depth.txt").read_text().splitlines()
    (folder / "depth.txt").write_text("\n".join(reversed(lines)))
    np.testing.assert_allclose([f.stamp for f in TumRgbdFolder(folder)], STAMPS, atol=1e-6)


@given(st.floats(-0.05, 0.15), st.floats(0.001, 0.04))
def test_poses_between_two_known_ones_are_interpolated(seconds: float, interval: float) -> None:
    known = path_at(STAMPS[0] + np.arange(-0.06, 0.2, interval))
    pose = pose_at(known, STAMPS[0] + seconds)
    expected = path_at(np.array([STAMPS[0] + seconds])).T_map_camera[0]
    np.testing.assert_allclose(pose.as_matrix(), expected.as_matrix(), atol=1e-6)


def test_no_pose_far_from_any_known_one() -> None:
    known = path_at(STAMPS[0] + np.array([0.0, 0.1]))
    near = pose_at(known, STAMPS[0] + 0.015)
    np.testing.assert_array_equal(near.as_matrix(), known.T_map_camera[0].as_matrix())
    with pytest.raises(InputError, match="no true pose within 20 ms"):
        pose_at(known, STAMPS[0] + 0.05)


def test_a_frame_without_a_true_pose_is_skipped_and_reported(folder: Path) -> None:
    write_tum(folder / "groundtruth.txt", path_at(STAMPS[0] + np.arange(-0.05, 0.04, 0.01)))
    scene = TumRgbdFolder(folder)
    assert len(list(scene)) == 2
    (name,) = scene.skipped
    assert name == f"depth/{STAMPS[2]:.6f}.png"
    assert "no true pose within 20 ms" in scene.skipped[name]


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def remove(path: Path) -> None:
    path.unlink()


def eight_bit(path: Path) -> None:
    Image.new("L", (640, 480)).save(path)


def too_small(path: Path) -> None:
    write_depth(path, 5000, size=(200, 100))


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("spoil", [truncate, remove, eight_bit, too_small, a_folder])
def test_one_bad_frame_is_skipped_and_reported(folder: Path, spoil) -> None:
    name = f"depth/{STAMPS[1]:.6f}.png"
    spoil(folder / name)
    scene = TumRgbdFolder(folder)
    assert [round(float(f.depth[9, 9]), 4) for f in scene] == [1.0, 1.2]
    assert list(scene.skipped) == [name]
    assert name in scene.skipped[name]
    assert "\n" not in scene.skipped[name]


def test_broken_or_distant_colour_keeps_the_frame_without_colour(folder: Path) -> None:
    truncate(folder / "rgb" / "0.png")
    late = [f"{STAMPS[0] + 0.011:.6f} rgb/0.png", f"{STAMPS[1] + 0.5:.6f} rgb/1.png"]
    (folder / "rgb.txt").write_text("\n".join(late))
    assert [frame.colour for frame in TumRgbdFolder(folder)] == [None, None, None]
    (folder / "rgb.txt").unlink()
    assert [frame.colour for frame in TumRgbdFolder(folder)] == [None, None, None]


def test_a_folder_without_readable_frames_is_refused_with_the_first_reason(folder: Path) -> None:
    for file in (folder / "depth").iterdir():
        file.unlink()
    with pytest.raises(InputError, match=r"none of 3 frames.*depth/.*can not be read"):
        list(TumRgbdFolder(folder))


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("depth.txt", b"", "depth.txt: lists no images"),
        ("depth.txt", b"# only comments\n", "lists no images"),
        ("depth.txt", b"1.0 depth/1.png\n2.0\n", "line 2: is not 'stamp file' but '2.0'"),
        ("depth.txt", b"soon depth/1.png\n", "line 1: is not 'stamp file'"),
        ("depth.txt", b"nan depth/1.png\n", "line 1: is not 'stamp file'"),
        ("depth.txt", b"inf depth/1.png\n", "line 1: is not 'stamp file'"),
        ("depth.txt", b"1.0 depth/\x001.png\n", "line 1: is not 'stamp file'"),
        ("depth.txt", bytes(range(128, 256)), "depth.txt: is not text"),
        ("rgb.txt", b"1.0\n", "rgb.txt: line 1"),
        ("groundtruth.txt", b"1 2 3\n", "groundtruth.txt: needs 8 columns"),
        ("groundtruth.txt", b"", "groundtruth.txt: holds no numbers"),
        ("groundtruth.txt", b"1 0 0 0 0 0 0 9\n", "unit length"),
        ("groundtruth.txt", b"1 0 0 nan 0 0 0 1\n", "no pose that is finite"),
        ("calibration.txt", b"1 2 3", "calibration.txt: contains 3 numbers, expected 4"),
        ("calibration.txt", b"0 0 0 0", "calibration.txt: is not a camera matrix"),
        ("camera-intrinsics.txt", b"1 2 3", "camera-intrinsics.txt"),
        ("gravity-direction.txt", b"0 0 0", "gravity-direction.txt: is not a direction"),
    ],
)
def test_broken_lists_end_in_one_line(folder: Path, name: str, content: bytes, word: str) -> None:
    (folder / name).write_bytes(content)
    with pytest.raises(InputError) as error:
        TumRgbdFolder(folder)
    assert word in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_folder_and_list(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        TumRgbdFolder(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"depth\.txt: can not be read"):
        TumRgbdFolder(tmp_path)


def test_the_kind_of_a_recording_follows_from_its_files(folder: Path, tmp_path: Path) -> None:
    assert isinstance(open_recording(folder, every=2), TumRgbdFolder)
    seven = tmp_path / "kitchen"
    seven.mkdir()
    write_depth(seven / "frame-000000.depth.png", 1000)
    np.savetxt(seven / "frame-000000.pose.txt", np.eye(4))
    scene = open_recording(seven, poses=False)
    assert isinstance(scene, SevenScenesFolder)
    assert next(iter(scene)).T_map_camera is None
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"contains none of metadata\.yaml .* depth\.txt"):
        open_recording(tmp_path / "empty")
    with pytest.raises(InputError, match="no such recording"):
        open_recording(tmp_path / "nowhere")


def test_one_pose_that_is_not_finite_is_skipped(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = folder / "groundtruth.txt"
    lines = file.read_text().splitlines()
    stamp = lines[5].split()[0]
    lines[5] = f"{stamp} nan nan nan 0 0 0 1"
    file.write_text("\n".join(lines))
    scene = TumRgbdFolder(folder)
    assert scene.truth is not None
    assert len(scene.truth) == len(lines) - 2
    assert len(list(scene)) == 3
    assert f"1 of {len(lines) - 1} poses left out: not finite" in caplog.text


def test_eth3d_s_calibration_is_that_of_the_camera(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    mine = folder.rename(folder.with_name("cables_1"))
    (mine / "calibration.txt").write_text(
        "726.28741455078 726.28741455078 354.6496887207 186.46566772461"
    )
    camera = next(iter(TumRgbdFolder(mine))).camera
    assert (camera.fx, camera.cy) == (726.28741455078, 186.46566772461)
    assert not caplog.text


def test_intrinsics_of_one_s_own_give_no_warning(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    mine = folder.rename(folder.with_name("mine"))
    np.savetxt(mine / "camera-intrinsics.txt", [[500, 0, 320], [0, 510, 240], [0, 0, 1]])
    assert next(iter(TumRgbdFolder(mine))).camera.fx == 500
    assert not caplog.text


def test_the_depth_scale_of_ones_own_millimetres(folder: Path) -> None:
    frames = list(open_recording(folder, depth_scale=1e-3))
    assert [round(float(f.depth[9, 9]), 3) for f in frames] == [5.0, 5.5, 6.0]
    assert np.isnan(frames[0].depth[0, :2]).all()
