"""RealSense cameras, by files that the SDK recorded of its software device."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realsense_files import UNIT, recorded

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import PinholeCamera
from circumspect.recording import realsense_camera
from circumspect.recording.realsense_camera import RealSenseCamera, realsense_sdk

CAMERA = PinholeCamera(64, 48, 60.5, 61.5, 31.25, 23.75)


@pytest.fixture(scope="module")
def sdk() -> Any:
    try:
        return realsense_sdk()
    except MissingExtraError:
        pytest.skip("the extra realsense is not installed")


def depths(count: int) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    made = [np.round(rng.uniform(0.5, 5.0, (48, 64)) / UNIT) * UNIT for _ in range(count)]
    for depth in made:
        depth[:2, :3] = np.nan
    return made


def test_every_frame_of_a_file_is_in_metres(tmp_path: Path, sdk: Any) -> None:
    written = depths(6)
    with RealSenseCamera(recorded(tmp_path / "run.db3", sdk, written, CAMERA)) as camera:
        assert camera.name == "Intel RealSense D455"
        assert camera.depth_range == (0.6, 6.0)
        found = list(camera)
    assert len(found) == len(written)
    for number, (frame, depth) in enumerate(zip(found, written, strict=True)):
        np.testing.assert_allclose(frame.depth, depth, rtol=1e-6)
        assert frame.stamp == pytest.approx(5 + 0.1 * number)
        assert frame.camera.fx == pytest.approx(CAMERA.fx)
        assert frame.camera.cy == pytest.approx(CAMERA.cy)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("Intel RealSense D405", (0.07, 0.5)), ("Intel RealSense D999", (0.3, 3.0))],
)
def test_the_depth_range_is_that_of_the_model(
    tmp_path: Path, sdk: Any, name: str, expected: tuple[float, float]
) -> None:
    path = recorded(tmp_path / "run.db3", sdk, depths(2), CAMERA, name)
    with RealSenseCamera(path) as camera:
        assert camera.depth_range == expected


def test_capture_ends_with_the_file(tmp_path: Path, sdk: Any) -> None:
    with RealSenseCamera(recorded(tmp_path / "run.db3", sdk, depths(2), CAMERA)) as camera:
        assert len(list(islice(camera.frames(2), 2))) == 2
        with pytest.raises(InputError, match=r"run\.db3: contains no more frames"):
            camera.capture()


def test_a_missing_camera_or_foreign_file_is_refused_with_the_reason(
    tmp_path: Path, sdk: Any
) -> None:
    with pytest.raises(InputError, match=r"no RealSense camera is connected; .*udev rules"):
        RealSenseCamera()
    with pytest.raises(InputError, match=r"gone\.db3: no such file"):
        RealSenseCamera(tmp_path / "gone.db3")
    for name in ("other.db3", "other.bag"):
        other = tmp_path / name
        other.write_bytes(b"#ROSBAG V2.0\nnothing")
        with pytest.raises(InputError, match=rf"{name}: the RealSense SDK can not play it"):
            RealSenseCamera(other)


def test_a_missing_sdk_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(realsense_camera, "import_module", missing)
    with pytest.raises(MissingExtraError, match=r"circumspect\[realsense\]"):
        realsense_sdk()
