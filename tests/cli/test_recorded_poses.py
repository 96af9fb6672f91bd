"""`replay --poses hidden`: the first pose places the map; the others only measure errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import RigidTransform

from circumspect.cli.main import main
from circumspect.cli.opened_recording import RecordedPoses
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise, RgbdFrame
from circumspect.simulation import Orbit, Scene, SimulatedCamera, Surface, block
from circumspect.tracking import Tracker

CAMERA = PinholeCamera(320, 240, 285.0, 285.0, 159.5, 119.5)
THING = block((-0.25, -0.35, 0.0), (0.25, 0.35, 0.6))
BOX = ["--box", "-0.4", "-0.5", "0.02", "0.4", "0.5", "0.7"]
WALLS = [((-1.6, -2.0, 0.0), (-1.5, 2.0, 2.0)), ((-1.6, -1.2, 0.0), (1.0, -1.1, 2.0))]
PATCH = np.s_[100:120, 140:160]
"""Too little depth to start a map."""


def covered_but(frame: RgbdFrame, kept_pixels: tuple[slice, slice] | None) -> RgbdFrame:
    depth = np.full_like(frame.depth, np.nan)
    if kept_pixels is not None:
        depth[kept_pixels] = frame.depth[kept_pixels]
    return replace(frame, depth=depth)


@pytest.fixture(scope="module")
def frames() -> list[RgbdFrame]:
    """On a short arc; the walls constrain the camera along the flat side of the object."""
    orbit = Orbit.around(THING, CAMERA)
    walls = [Surface(f"wall {n}", block(*corners)) for n, corners in enumerate(WALLS)]
    camera = SimulatedCamera(
        Scene.with_object(THING, *walls), orbit.stations(400).__next__, CAMERA, DepthNoise(), 0
    )
    return list(islice(camera.frames(400), 7))


def as_seven_scenes(folder: Path, frames: list[RgbdFrame]) -> None:
    for number, frame in enumerate(frames):
        stem = folder / f"frame-{number:06d}"
        save_depth(f"{stem}.depth.png", 1e3 * frame.depth)
        np.savetxt(f"{stem}.pose.txt", frame.pose.as_matrix())
    np.savetxt(folder / "gravity-direction.txt", [0, 0, -1])


def as_tum_rgbd(folder: Path, frames: list[RgbdFrame]) -> None:
    for frame in frames:
        save_depth(folder / f"{frame.stamp:.4f}.png", 5e3 * frame.depth)
    depth = [f"{frame.stamp:.4f} {frame.stamp:.4f}.png" for frame in frames]
    rows = [(frame.stamp, frame.pose.translation, frame.pose.rotation) for frame in frames]
    (folder / "depth.txt").write_text("\n".join(depth))
    np.savetxt(folder / "groundtruth.txt", [[t, *xyz, *R.as_quat()] for t, xyz, R in rows])


def save_depth(path: str | Path, values: np.ndarray) -> None:
    Image.fromarray(np.nan_to_num(values).round().astype(np.uint16)).save(path)


Layout = Callable[[Path, list[RgbdFrame]], None]


def write(folder: Path, frames: list[RgbdFrame], layout: Layout) -> Path:
    folder.mkdir()
    layout(folder, frames)
    c = CAMERA
    matrix = [[c.fx, 0, c.cx], [0, c.fy, c.cy], [0, 0, 1]]
    np.savetxt(folder / "camera-intrinsics.txt", matrix)
    return folder


@pytest.mark.parametrize("layout", [as_seven_scenes, as_tum_rgbd])
@pytest.mark.parametrize("kept_pixels", [None, PATCH], ids=["blank", "too little"])
def test_first_frames_without_enough_depth_do_not_end_a_replay(
    layout: Layout,
    kept_pixels: tuple[slice, slice] | None,
    frames: list[RgbdFrame],
    tmp_path: Path,
    capsys: pytest.CaptureFixture,
) -> None:
    shots = [*(covered_but(frame, kept_pixels) for frame in frames[:2]), *frames[2:]]
    folder = write(tmp_path / "scene", shots, layout)
    out = ["--out", str(tmp_path / "run"), "--json"]
    assert main(["replay", str(folder), *BOX, "--poses", "hidden", *out]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["frames"] == 7
    # The map lies where the recorded poses say, or there would be nothing in the box.
    assert result["outcomes"]["classified"] >= 3
    # A camera that never moved would be off by 25 mm.
    assert result["ate_rmse_m"] < 0.005
    assert result["yaw_rmse_deg"] <= result["rotation_rmse_deg"] < 0.5
    kept = json.loads((tmp_path / "run" / "replay.json").read_text())["measured"]
    assert set(kept) == {
        "ate_rmse_m", "rotation_rmse_deg", "yaw_rmse_deg", "frame_error_median_m",
    }  # fmt: skip
    assert kept == {name: result[name] for name in kept}


def test_rotation_error_and_yaw_error_are_reported_separately() -> None:
    errors = {
        "ate_rmse_m": 0.0234, "rotation_rmse_deg": 1.5, "yaw_rmse_deg": 0.95,
        "frame_error_median_m": 0.0012,
    }  # fmt: skip
    sentence = RecordedPoses.sentence(errors)
    assert "turned by 1.50°, about the vertical alone (yaw) by 0.95° (RMSE);" in sentence


def test_recorded_poses_after_the_first_do_not_change_the_estimate(frames: list[RgbdFrame]) -> None:
    """Frames carry the recorded poses, but only errors are measured with them."""
    shots = [covered_but(frames[0], None), *frames[1:]]
    wrong = RigidTransform.from_translation([3.0, -2.0, 1.0])
    lies = [*shots[:2], *(frame.at(wrong * frame.pose) for frame in shots[2:])]
    none = [*shots[:2], *(replace(frame, T_map_camera=None) for frame in shots[2:])]
    np.testing.assert_array_equal(found(shots), found(lies))
    np.testing.assert_array_equal(found(shots), found(none))


def found(frames: list[RgbdFrame]) -> np.ndarray:
    poses = Tracker()
    noted = RecordedPoses().noted(frames)
    return np.array([poses.track(frame).T_map_camera.as_matrix() for frame in noted])
