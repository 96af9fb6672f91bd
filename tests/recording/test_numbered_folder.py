"""Folders of ScanNet and of Open3D."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.recording import FrameFolder, open_recording
from circumspect.recording.numbered_folder import Open3dFolder, ScanNetFolder

SIZE = 40, 30
K = np.array([[36.0, 0.0, 19.5], [0.0, 37.0, 14.5], [0.0, 0.0, 1.0]])


def pose(number: int) -> RigidTransform:
    turn = Rotation.from_rotvec([0.1 * number, 0.2, -0.3])
    return RigidTransform.from_components([0.1 * number, 1.0, 1.5], turn)


def write_images(folder: Path, colour_size: tuple[int, int], name: str = "{}") -> None:
    for sub in ("depth", "color"):
        (folder / sub).mkdir(parents=True)
    for number in range(11):
        depth = np.full(SIZE[::-1], 1000 + number, np.uint16)
        depth[0, :2] = 0, 65535
        Image.fromarray(depth).save(folder / "depth" / f"{name.format(number)}.png")
        colour = Image.new("RGB", colour_size, (20 * number, 0, 0))
        colour.save(folder / "color" / f"{name.format(number)}.jpg")


@pytest.fixture
def scannet(tmp_path: Path) -> Path:
    """As SensReader exports a scene; its colour camera has more pixels."""
    folder = tmp_path / "scene0000_00"
    write_images(folder, (130, 97))
    (folder / "intrinsic").mkdir()
    (folder / "pose").mkdir()
    large = np.eye(4)
    large[:3, :3] = K
    np.savetxt(folder / "intrinsic" / "intrinsic_depth.txt", large)
    for number in range(11):
        np.savetxt(folder / "pose" / f"{number}.txt", pose(number).as_matrix())
    return folder


@pytest.fixture
def open3d(tmp_path: Path) -> Path:
    """As Open3D's recorder and reconstruction system write it."""
    folder = tmp_path / "recording"
    write_images(folder, SIZE, "{:06d}")
    intrinsic = {"width": 40, "height": 30, "intrinsic_matrix": K.T.ravel().tolist()}
    (folder / "camera_intrinsic.json").write_text(json.dumps(intrinsic))
    (folder / "scene").mkdir()
    with (folder / "scene" / "trajectory.log").open("w") as stream:
        for number in range(11):
            stream.write(f"{number} {number} {number + 1}\n")
            np.savetxt(stream, pose(number).as_matrix())
    return folder


@pytest.mark.parametrize("kind", ["scannet", "open3d"])
def test_frames_come_by_their_numbers_with_depth_camera_and_pose(
    kind: str, request: pytest.FixtureRequest
) -> None:
    recording = open_recording(request.getfixturevalue(kind))
    assert isinstance(recording, ScanNetFolder if kind == "scannet" else Open3dFolder)
    found = list(recording)
    assert not recording.skipped
    assert [round(float(one.depth[9, 9]), 3) for one in found] == [1 + n / 1000 for n in range(11)]
    assert np.isnan(found[0].depth[0, :2]).all()
    assert [one.stamp for one in found] == pytest.approx(np.arange(11) / 30)
    camera = found[0].camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (36.0, 37.0, 19.5, 14.5)
    for number, one in enumerate(found):
        np.testing.assert_allclose(one.pose.as_matrix(), pose(number).as_matrix(), atol=1e-9)
        assert (one.colour is not None) == (kind == "open3d"), "colour lies on the depth"


def test_frames_with_lost_scannet_poses_are_skipped(scannet: Path) -> None:
    np.savetxt(scannet / "pose" / "4.txt", np.full((4, 4), -np.inf))
    recording = open_recording(scannet)
    assert len(list(recording)) == 10
    assert list(recording.skipped) == ["depth/4.png"]
    assert "4.txt: contains NaN or infinite numbers" in recording.skipped["depth/4.png"]


def test_every_nth_and_the_depth_scale(open3d: Path) -> None:
    found = list(open_recording(open3d, every=5, depth_scale=2.5e-4))
    assert [one.stamp for one in found] == pytest.approx([0, 5 / 30, 10 / 30])
    np.testing.assert_allclose(found[1].depth[9, 9], 1005 * 2.5e-4, rtol=1e-6)


def test_without_poses_there_are_none(scannet: Path, open3d: Path) -> None:
    for file in (scannet / "pose").iterdir():
        file.unlink()
    (scannet / "pose").rmdir()
    (open3d / "scene" / "trajectory.log").unlink()
    for folder in (scannet, open3d):
        recording = open_recording(folder, poses=False)
        assert isinstance(recording, FrameFolder)
        assert not recording.has_poses
        assert all(one.T_map_camera is None for one in recording)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("camera_intrinsic.json", None, r"has no intrinsics; write camera-intrinsics.txt"),
        ("camera_intrinsic.json", "{}", "contains no 'intrinsic_matrix' of nine numbers"),
        ("camera_intrinsic.json", '{"intrinsic_matrix": [1, 2]}', "of nine numbers"),
        (
            "camera_intrinsic.json",
            '{"intrinsic_matrix": [0,0,0,0,0,0,0,0,0]}',
            "not a camera matrix",
        ),
        ("scene/trajectory.log", "1 2 3", "3 numbers and a 4 x 4 matrix per frame"),
        ("scene/trajectory.log", "0 0 1" + " 2" * 16, "rotation is not orthonormal"),
        ("scene/trajectory.log", "0 0 1 x", "something other than numbers"),
    ],
)
def test_missing_and_broken_files_are_reported_in_one_line(
    open3d: Path, name: str, content: str | None, words: str
) -> None:
    if content is None:
        (open3d / name).unlink()
    else:
        (open3d / name).write_text(content)
    with pytest.raises(InputError, match=words) as error:
        open_recording(open3d)
    assert "\n" not in str(error.value)


def test_a_folder_without_numbered_images_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "depth").mkdir()
    with pytest.raises(InputError, match="depth: contains no numbered PNG images"):
        open_recording(tmp_path)


def test_the_folder_s_own_intrinsics_come_first(open3d: Path) -> None:
    np.savetxt(open3d / "camera-intrinsics.txt", [[50, 0, 20], [0, 51, 15], [0, 0, 1]])
    assert next(iter(open_recording(open3d))).camera.fy == 51.0
