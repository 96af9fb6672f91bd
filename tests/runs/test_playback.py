"""The playback files of a run: round trips, limits, and untrusted files."""

from __future__ import annotations

import dataclasses
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scan_world
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.runs import RunFolder, playback_log
from circumspect.runs.playback_log import PlaybackLog
from circumspect.runs.playback_moment import (
    MAX_POINTS,
    MAX_STEPS,
    MIN_STEP_M,
    PlaybackMoment,
    thinned,
)
from circumspect.runs.surroundings import Surroundings
from circumspect.simulation import Scene, Surface, block

CAMERA = PinholeCamera(640, 480, 570.0, 571.0, 319.5, 239.5)


def moment(points: int = 50, seed: int = 0, **changes) -> PlaybackMoment:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(points, 3))
    grid = CylindricalGrid((4, 8, 4), 0.5, 0.6, (3.0, -2.0, 0.4), 0.3)
    depth = rng.uniform(0.5, 4.0, (12, 16)).astype(np.float32)
    depth[0, :3] = np.nan
    given_values = {
        "frame": 7,
        "points_xyz": rng.normal(size=(points, 3)) + np.array([3.0, -2.0, 0.4]),
        "normals_xyz": normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9),
        "frames_seen": rng.integers(1, 300, points),
        "grid": OccupancyGrid(grid, (2 * rng.integers(0, 2, grid.shape)).astype(np.uint8)),
        "depth": depth,
        "colour": rng.integers(0, 256, (12, 16, 3)).astype(np.uint8),
        "camera": CAMERA,
        "T_base_camera": RigidTransform.from_components(
            [0.1, 0.2, 1.2], Rotation.from_euler("xyz", [1.0, 0.2, -0.4])
        ),
        "target": np.array([1.0, 2.0, 0.5, 0.1, 0.2, np.nan]),
    }
    return PlaybackMoment(**(given_values | changes))


@given(points=st.integers(0, 60), seed=st.integers(0, 1000))
def test_a_moment_round_trip(tmp_path_factory, points, seed):
    path = tmp_path_factory.mktemp("moment") / "a.npz"
    written = moment(points, seed)
    written.save(path)
    read = PlaybackMoment.load(path)
    np.testing.assert_allclose(read.points_xyz, written.points_xyz, atol=MIN_STEP_M)
    np.testing.assert_allclose(read.normals_xyz, written.normals_xyz, atol=0.005)
    np.testing.assert_array_equal(read.frames_seen, written.frames_seen)
    np.testing.assert_array_equal(read.grid.states, written.grid.states)
    assert read.grid.grid == written.grid.grid
    np.testing.assert_allclose(read.depth, written.depth, atol=6e-4)
    np.testing.assert_array_equal(read.colour, written.colour)
    np.testing.assert_array_equal(read.target, written.target)
    np.testing.assert_allclose(
        read.T_base_camera.as_matrix(), written.T_base_camera.as_matrix(), atol=1e-12
    )
    assert (read.frame, read.camera) == (7, CAMERA)


def test_missing_parts_of_a_moment_stay_missing(tmp_path):
    written = moment(0, grid=None, colour=None, T_base_camera=None, target=None)
    written.save(tmp_path / "a.npz")
    read = PlaybackMoment.load(tmp_path / "a.npz")
    assert read.grid is None
    assert read.colour is None
    assert read.T_base_camera is None
    assert read.target is None
    assert len(read.points_xyz) == 0


@pytest.mark.parametrize("far", [16.0, 40.0, -2000.0])
def test_points_far_from_the_first_one_keep_their_place(tmp_path, far):
    written = moment()
    points = written.points_xyz.copy()
    points[-1, 1] = points[0, 1] + far
    written = dataclasses.replace(written, points_xyz=points)
    written.save(tmp_path / "a.npz")
    read = PlaybackMoment.load(tmp_path / "a.npz")
    step = max(MIN_STEP_M, abs(far) / MAX_STEPS)
    np.testing.assert_allclose(read.points_xyz, points, rtol=0, atol=0.51 * step)


def test_a_moment_of_an_older_version_without_steps_is_read(tmp_path):
    path = tmp_path / "a.npz"
    written = moment()
    written.save(path)
    with np.load(path) as new:
        np.savez(path, **{name: new[name] for name in new.files if name != "step"})
    np.testing.assert_allclose(
        PlaybackMoment.load(path).points_xyz, written.points_xyz, atol=MIN_STEP_M
    )


def test_a_large_object_is_thinned(tmp_path):
    moment(5 * MAX_POINTS).save(tmp_path / "a.npz")
    assert 0.5 * MAX_POINTS < len(PlaybackMoment.load(tmp_path / "a.npz").points_xyz) <= MAX_POINTS


def test_images_are_thinned_to_thumbnails():
    assert thinned(np.zeros((480, 640))).shape == (120, 160)
    assert thinned(np.zeros((90, 120))).shape == (90, 120)


def changed(path: Path, **arrays: np.ndarray) -> Path:
    """The file with some of its arrays replaced."""
    with np.load(path) as old:
        kept = {name: old[name] for name in old.files}
    np.savez(path, **(kept | arrays))
    return path


@pytest.mark.parametrize(
    "wrong",
    [
        {"points": np.zeros((5, 2), np.int16)},
        {"normals": np.zeros((4, 3), np.int8)},
        {"frames_seen": np.zeros(3, np.uint16)},
        {"camera": np.array([1.0, 2.0])},
        {"camera": np.full(6, np.nan)},
        {"depth": np.zeros((3, 3))},
        {"colour": np.zeros((2, 2, 3), np.uint8)},
        {"mount": np.zeros(7)},
        {"target": np.full(6, np.inf)},
        {"cells": np.array([1000, 1000, 1000])},
        {"cells": np.array([-4, 8, 4])},
        {"bounds": np.full(6, np.nan)},
        {"occupied": np.zeros(1, np.uint8)},
        {"points": np.array(["a", "b"])},
        {"frame": np.array([np.inf])},
        {"frame": np.array([np.nan])},
        {"cells": np.array([np.inf, 1, 1])},
        {"step": np.array([0.0])},
        {"step": np.array([np.nan])},
        {"step": np.array([1e300])},
        {"step": np.array([5e-4, 5e-4])},
    ],
)
def test_an_invalid_moment_is_refused(tmp_path, wrong):
    moment().save(tmp_path / "a.npz")
    with pytest.raises(InputError, match=r"a\.npz"):
        PlaybackMoment.load(changed(tmp_path / "a.npz", **wrong))


def test_broken_and_oversized_archives_are_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        PlaybackMoment.load(tmp_path / "none.npz")
    (tmp_path / "a.npz").write_bytes(b"PK\x03\x04 and then nothing")
    with pytest.raises(InputError, match=r"a\.npz"):
        PlaybackMoment.load(tmp_path / "a.npz")
    moment().save(tmp_path / "b.npz")
    # An archive that unpacks to far more than any moment has.
    bomb = io.BytesIO()
    np.lib.format.write_array(bomb, np.zeros(40 << 20, np.uint8))
    with (
        zipfile.ZipFile(tmp_path / "c.npz", "w", zipfile.ZIP_DEFLATED) as archive,
        zipfile.ZipFile(tmp_path / "b.npz") as old,
    ):
        for name in old.namelist():
            archive.writestr(name, bomb.getvalue() if name == "depth.npy" else old.read(name))
    with pytest.raises(InputError, match="MiB"):
        PlaybackMoment.load(tmp_path / "c.npz")


class TestSurroundings:
    SCENE = Scene.with_object(
        block((-0.1, -0.1, 0.0), (0.1, 0.1, 0.5)),
        Surface("wall-0", block((2.0, -2.0, 0.0), (2.1, 2.0, 2.4)), (0.1, 0.2, 0.3)),
        Surface("box-1", block((1.0, 1.0, 0.0), (1.2, 1.2, 0.4)), (0.9, 0.8, 0.7)),
    )
    T = RigidTransform.from_components([1.0, 2.0, 0.0], Rotation.from_euler("z", 0.7))

    def test_object_and_floor_are_no_surroundings(self):
        meshes = Surroundings.of(self.SCENE, self.T).meshes
        assert [mesh.wall for mesh in meshes] == [True, False]

    def test_surroundings_round_trip(self, tmp_path):
        written = Surroundings.of(self.SCENE, self.T)
        written.save(tmp_path / "s.npz")
        read = Surroundings.load(tmp_path / "s.npz")
        for one, other in zip(written.meshes, read.meshes, strict=True):
            np.testing.assert_array_equal(one.vertices_xyz, other.vertices_xyz)
            np.testing.assert_array_equal(one.faces, other.faces)
            np.testing.assert_array_equal(one.colour, other.colour)
            assert one.wall == other.wall

    def test_empty_surroundings_round_trip(self, tmp_path):
        Surroundings().save(tmp_path / "s.npz")
        assert Surroundings.load(tmp_path / "s.npz").meshes == ()

    @pytest.mark.parametrize(
        "wrong",
        [
            {"counts": np.array([[8, 12, 1], [900, 12, 0]], np.int32)},
            {"counts": np.array([[-8, 12, 1], [8, 12, 0]], np.int32)},
            {"faces": np.full((24, 3), 99, np.int32)},
            {"vertices_xyz": np.full((16, 3), np.nan, np.float32)},
            {"colours": np.zeros((5, 3), np.float32)},
        ],
    )
    def test_invalid_surroundings_are_refused(self, tmp_path, wrong):
        Surroundings.of(self.SCENE, self.T).save(tmp_path / "s.npz")
        with pytest.raises(InputError, match=r"s\.npz"):
            Surroundings.load(changed(tmp_path / "s.npz", **wrong))


def test_a_long_run_keeps_few_moments(tmp_path, monkeypatch):
    """When there are too many every second one goes, so that they stay evenly spread."""
    monkeypatch.setattr(playback_log, "MAX_MOMENTS", 6)
    scan = scan_world.scan()
    log = PlaybackLog(scan, tmp_path)
    result = scan.run((log,))
    numbers = sorted(int(file.stem) for file in (tmp_path / "playback").glob("[0-9]*.npz"))
    assert len(result.steps) > 14
    assert numbers[0] == 0
    assert 3 <= len(numbers) <= 6
    assert len(set(np.diff(numbers))) == 1
    last = PlaybackMoment.load(tmp_path / "playback" / f"{numbers[-1]:06d}.npz")
    assert len(last.points_xyz) > 100
    assert last.target is not None
    assert (tmp_path / "playback" / "odometry.npz").is_file()


def test_moments_of_an_earlier_run_are_removed_and_nothing_else(tmp_path):
    folder = tmp_path / "playback"
    RunFolder(tmp_path, {})
    folder.mkdir()
    for name in ("000003.npz", "odometry.npz", "mine.txt"):
        (folder / name).write_text("old")
    RunFolder(tmp_path, {})
    assert [file.name for file in folder.iterdir()] == ["mine.txt"]
