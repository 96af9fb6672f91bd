from __future__ import annotations

import os
import zipfile

import numpy as np
import pytest
from grid_cases import grids, seeds
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from circumspect.errors import CircumspectError, InputError, OutputError
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.grid.grid_file import holds_grid

same_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def some_states(grid, seed=0):
    return OccupancyGrid(grid, np.random.default_rng(seed).integers(0, 3, grid.shape, np.uint8))


def arrays_of(path):
    with np.load(path) as archive:
        return dict(archive)


@same_folder
@given(grids(), seeds)
def test_a_saved_grid_round_trips(tmp_path, grid, seed):
    saved, path = some_states(grid, seed), tmp_path / "grid.npz"
    saved.save(path)
    loaded = OccupancyGrid.load(path)
    assert holds_grid(path)
    assert loaded.grid == saved.grid
    assert np.array_equal(loaded.states, saved.states)


def test_a_file_is_small_and_plain(tmp_path):
    path = tmp_path / "deep" / "grid.npz"
    OccupancyGrid(CylindricalGrid(), np.zeros((32, 32, 32), np.uint8)).save(path)
    assert path.stat().st_size < 3000
    arrays = arrays_of(path)
    assert arrays["radius"] == 1.0
    assert arrays["occupied"].shape == (4096,)
    assert all(array.dtype != object for array in arrays.values())


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> bytes:
    """The arrays of a valid file."""
    path = tmp_path_factory.mktemp("sound") / "grid.npz"
    some_states(CylindricalGrid((3, 8, 5), azimuth_offset=0.1)).save(path)
    return path.read_bytes()


@settings(same_folder, max_examples=300)
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=4), st.data())
def test_mutated_files_are_refused_or_valid(tmp_path, sound, flips, data):
    content = bytearray(sound)
    for place, value in flips:
        content[place % len(content)] = value
    keep = data.draw(st.one_of(st.just(len(content)), st.integers(0, len(content))))
    path = tmp_path / "mutated.npz"
    path.write_bytes(content[:keep])
    holds_grid(path)
    fault = None
    try:
        loaded = OccupancyGrid.load(path)
        assert loaded.states.shape == loaded.grid.shape
    except CircumspectError as error:
        fault = str(error)
    assert fault is None or (str(path) in fault and "\n" not in fault)


@settings(same_folder, max_examples=60)
@given(st.binary(max_size=200))
def test_any_bytes_are_refused(tmp_path, content):
    path = tmp_path / "any.npz"
    path.write_bytes(content)
    assert not holds_grid(path)
    with pytest.raises(InputError):
        OccupancyGrid.load(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": None}, "not a grid file: it holds"),
        ({"extra": np.zeros(3)}, "not a grid file: it holds"),
        ({"version": np.array([2])}, "version 2"),
        ({"shape": np.array([3, 8])}, "shape must be int64 of shape"),
        ({"shape": np.array([3.0, 8.0, 5.0])}, "shape must be int64"),
        ({"shape": np.array([3, 8, -5])}, "from 1 to 4096"),
        ({"shape": np.array([4096, 4096, 4096])}, "take fewer"),
        ({"shape": np.array([2**62, 8, 5])}, "from 1 to 4096"),
        ({"shape": np.array([4, 8, 5])}, "occupied must be uint8 of shape"),
        ({"occupied": np.zeros(15, np.float32)}, "occupied must be uint8"),
        ({"occupied": np.zeros((15, 1), np.uint8)}, "occupied must be an array of shape"),
        ({"free": np.full(15, 255, np.uint8)}, "both occupied and free"),
        ({"occupied": np.zeros(15, object)}, "occupied must be"),
        ({"radius": np.array([-1.0])}, "radius must lie between"),
        ({"half_height": np.array([np.nan])}, "half_height must be finite"),
        ({"centre_xyz": np.array([0.0, np.inf, 0.0])}, "centre is three numbers"),
        ({"radius": np.array(1.0)}, "radius must be an array"),
    ],
)
def test_wrong_arrays_are_named(tmp_path, sound, changes, message):
    path = tmp_path / "wrong.npz"
    path.write_bytes(sound)
    arrays = {**arrays_of(path), **changes}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(InputError, match=message):
        OccupancyGrid.load(path)


def test_bits_beyond_the_last_cell_are_refused(tmp_path):
    path = tmp_path / "grid.npz"
    some_states(RectangularGrid((3, 3, 3))).save(path)
    arrays = arrays_of(path)
    arrays["free"] = arrays["free"] | np.array([0, 0, 0, 1], np.uint8)
    np.savez(path, **arrays)
    with pytest.raises(InputError, match="beyond the last cell"):
        OccupancyGrid.load(path)


def test_an_oversized_header_allocates_no_memory(tmp_path, sound):
    path = tmp_path / "bomb.npz"
    path.write_bytes(sound)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["occupied.npy"] = members["occupied.npy"].replace(b"(15,), }", b"(9999999999,), }")
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    with pytest.raises(InputError, match="occupied must be"):
        OccupancyGrid.load(path)


def test_missing_files_folders_and_other_archives(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        OccupancyGrid.load(tmp_path / "none.npz")
    with pytest.raises(InputError, match="is a folder"):
        OccupancyGrid.load(tmp_path)
    os.mkfifo(tmp_path / "pipe.npz")  # No process writes into the pipe.
    with pytest.raises(InputError, match="not a regular file"):
        OccupancyGrid.load(tmp_path / "pipe.npz")
    np.savez(tmp_path / "cloud.npz", points=np.zeros((4, 3)))
    with pytest.raises(InputError, match="not a grid file: it holds points"):
        OccupancyGrid.load(tmp_path / "cloud.npz")
    assert not holds_grid(tmp_path / "cloud.npz")
    assert not holds_grid(tmp_path / "none.npz")
    with pytest.raises(OutputError):
        some_states(CylindricalGrid((2, 2, 2))).save(tmp_path)
