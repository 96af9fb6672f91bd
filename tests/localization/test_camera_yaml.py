"""Lenses of other programs: YAML of ROS, OpenCV and Kalibr, and other forms of numbers in JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from ceiling_world import camera, lens
from hypothesis import given
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.localization import (
    Calibration,
    LensCamera,
    read_calibration,
    read_lenses,
    write_calibration,
)
from circumspect.localization.lens_camera import COEFFICIENT_COUNTS, lens_of

LENS = lens()
PINHOLE = LENS.pinhole
MATRIX = [PINHOLE.fx, 0.0, PINHOLE.cx, 0.0, PINHOLE.fy, PINHOLE.cy, 0.0, 0.0, 1.0]
BEND = list(LENS.distortion)


def ros(bend: list[float] = BEND, model: str = "plumb_bob") -> str:
    """As camera_calibration_parsers writes it."""
    return f"""image_width: {PINHOLE.width}
image_height: {PINHOLE.height}
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: {MATRIX}
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {len(bend)}
  data: {bend}
"""


def opencv(size: str = f"image_width: {PINHOLE.width}\nimage_height: {PINHOLE.height}\n") -> str:
    """As cv::FileStorage writes it."""
    return f"""%YAML:1.0
---
calibration_time: "Tue 24 Nov 2026"
{size}camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: {MATRIX}
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: {BEND}
"""


def kalibr(model: str = "radtan", more: str = "") -> str:
    """As kalibr_calibrate_cameras writes it; radtan has four coefficients."""
    return f"""cam0:
  camera_model: pinhole
  intrinsics: [{PINHOLE.fx}, {PINHOLE.fy}, {PINHOLE.cx}, {PINHOLE.cy}]
  distortion_model: {model}
  distortion_coeffs: {BEND[:4]}
  resolution: [{PINHOLE.width}, {PINHOLE.height}]
  rostopic: /ceiling_0/image_raw
{more}"""


def read(path: Path, content: str, name: str = "ceiling_0") -> LensCamera:
    path.write_text(content)
    known = read_lenses(path, name)
    assert list(known.lenses) == [name]
    return known.lens(name)


@pytest.mark.parametrize("content", [ros(), ros([*BEND, 0, 0, 0], "rational_polynomial"), opencv()])
def test_a_lens_of_ros_and_opencv_is_read(tmp_path: Path, content: str) -> None:
    assert read(tmp_path / "camera.yaml", content) == LENS


def test_a_lens_that_cv_file_storage_wrote_is_read(tmp_path: Path) -> None:
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / "out_camera_data.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", PINHOLE.width)
    storage.write("image_height", PINHOLE.height)
    storage.write("camera_matrix", np.array(MATRIX).reshape(3, 3))
    storage.write("distortion_coefficients", np.array(BEND).reshape(5, 1))
    storage.release()
    assert read_lenses(path, "c").lens("c") == LENS


def test_a_lens_of_kalibr_is_read_with_four_coefficients(tmp_path: Path) -> None:
    found = read(tmp_path / "camchain.yaml", kalibr())
    assert found == LensCamera(PINHOLE, (*LENS.distortion[:4], 0.0))


def test_of_several_cameras_of_kalibr_the_named_one_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "camchain.yaml"
    both = kalibr(more=kalibr().replace("cam0", "cam1").replace(str(PINHOLE.fx), "700.5"))
    assert read(path, both, "cam1").pinhole.fx == 700.5
    with pytest.raises(InputError, match=r"holds several cameras, cam0, cam1, and none is 'c'"):
        read(path, both, "c")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (kalibr("equidistant"), "lens model 'equidistant' is not supported (fisheye lenses are"),
        (ros([0.1, 0, 0, 0], "fisheye"), "lens model 'fisheye' is not supported"),
        (ros([*BEND, 0.1, 0, 0], "rational_polynomial"), "beyond k1, k2, p1, p2, k3 (rational"),
        (ros([0.1, 0.2]), "4, 5, 8, 12 or 14 coefficients (k1, k2, p1, p2, k3, …), not 2"),
        (opencv(""), "has no image_width; calibrate with: circumspect locate intrinsics"),
        ("image_width: 3\nimage_height: 4\n", "has no camera_matrix"),
        (ros().replace("data", "dota"), "needs 9 finite numbers in camera_matrix"),
        (ros().replace("1.0]", ".nan]"), "needs 9 finite numbers in camera_matrix"),
        (kalibr().replace("pinhole", "omni"), "camera model 'omni' is not supported"),
        ("- 1\n", "holds no camera"),
        ("a: [", "is not YAML at line"),
        ("a: &x [1]\nb: *x\n", "has aliases"),
        ("a: !!python/object/apply:os.system [ls]\n", "is not YAML"),
    ],
)
def test_unusable_files_are_refused_with_a_remedy(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "camera.yaml"
    with pytest.raises(InputError) as error:
        read(path, content)
    assert str(error.value).startswith(f"{path}: ")
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_other_files_and_a_yaml_without_a_place_are_refused(tmp_path: Path) -> None:
    archive = tmp_path / "cal.npz"
    np.savez(archive, K=np.eye(3))
    with pytest.raises(InputError, match=r"cal\.npz: unsupported; supported are JSON .* Kalibr"):
        read_lenses(archive, "c")
    (tmp_path / "ros.yaml").write_text(ros())
    with pytest.raises(InputError, match=r"YAML files contain a lens, but no pose; .*extrinsics"):
        read_calibration(tmp_path / "ros.yaml")


@given(st.sampled_from(COEFFICIENT_COUNTS), st.booleans(), st.booleans())
def test_our_own_file_may_hold_the_numbers_in_other_forms(
    tmp_path_factory: pytest.TempPathFactory, count: int, nested: bool, flat: bool
) -> None:
    path = tmp_path_factory.mktemp("room") / "room.json"
    write_calibration(path, Calibration.of([camera(name="north")]))
    document = json.loads(path.read_text())
    entry = document["cameras"]["north"]
    bend = (entry["distortion"] + [0.0] * 9)[:count]
    entry["distortion"] = [bend] if nested else bend
    if flat:
        entry["K"] = [value for row in entry["K"] for value in row]
    path.write_text(json.dumps(document))
    expected = camera(name="north").lens
    found = read_lenses(path, "north").lens("north")
    assert found.pinhole == expected.pinhole
    assert found.distortion == (*expected.distortion[:4], expected.distortion[4] * (count > 4))


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"model": "fisheye"}, "camera 'north': the lens model 'fisheye' is not supported"),
        ({"distortion": [0.1, 0, 0, 0, 0, 0.2, 0, 0]}, "rational"),
    ],
)
def test_lens_models_of_our_own_file_that_are_not_ours_are_refused(
    tmp_path: Path, entry: dict, words: str
) -> None:
    path = tmp_path / "room.json"
    write_calibration(path, Calibration.of([camera(name="north")]))
    document = json.loads(path.read_text())
    document["cameras"]["north"] |= entry
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=words):
        read_lenses(path, "north")


def test_skew_is_named() -> None:
    with pytest.raises(InputError, match=r"without skew.*circumspect locate intrinsics"):
        lens_of((640, 480), [500, 0.3, 320, 0, 500, 240, 0, 0, 1], BEND)
