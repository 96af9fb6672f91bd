"""What a caller may pass as points, and the errors for anything else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud, TriangleMesh, read_cloud, write_ply
from circumspect.grid import CylindricalGrid, RectangularGrid

POINTS = np.random.default_rng(0).normal(size=(50, 3))
MESH = TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
BOUNDS = CylindricalGrid((4, 8, 4), 5.0, 5.0)

TAKERS = {
    "CylindricalGrid.fit": CylindricalGrid.fit,
    "RectangularGrid.fit": RectangularGrid.fit,
    "hits": BOUNDS.hits,
    "write_ply": lambda points: write_ply("never.ply", points),
}
takers = pytest.mark.parametrize("take", TAKERS.values(), ids=TAKERS)


def structured(points: np.ndarray, dtype: str = "<f4") -> np.ndarray:
    """Points as ROS and PCL have them: with padding and a field that is no coordinate."""
    table = np.zeros(
        len(points),
        {"names": [*"xyz", "ring"], "formats": [dtype] * 3 + ["<u2"], "offsets": [0, 8, 16, 24],
         "itemsize": 32},
    )  # fmt: skip
    for axis, column in zip("xyz", points.T, strict=True):
        table[axis] = column
    return table


@takers
def test_a_mesh_in_place_of_points_is_refused_with_a_remedy(take):
    with pytest.raises(InputError, match=r"mesh\.sampled\("):
        take(MESH)


@takers
@pytest.mark.parametrize("path", ["chair.ply", Path("chair.ply")])
def test_a_path_in_place_of_points_is_refused_with_a_remedy(take, path):
    with pytest.raises(InputError, match=r"circumspect\.read_cloud\(path\)"):
        take(path)


@takers
@pytest.mark.parametrize(
    "bad", [np.ma.masked_less(POINTS, 0), POINTS + 0j, POINTS > 0, POINTS.astype(str), object()]
)
def test_values_that_are_no_numeric_array_are_refused(take, bad):
    with pytest.raises(InputError):
        take(bad)


@pytest.mark.parametrize("kind", [CylindricalGrid, RectangularGrid])
def test_grids_fit_arrays(kind):
    assert kind.fit(POINTS) == kind.fit(PointCloud(POINTS)) == kind.fit(POINTS.tolist())


def test_an_array_is_written_as_a_cloud(tmp_path):
    write_ply(tmp_path / "cloud.ply", POINTS)
    np.testing.assert_array_equal(read_cloud(tmp_path / "cloud.ply").points_xyz, POINTS)


def test_numpy_takes_a_cloud_as_its_points():
    cloud = PointCloud(POINTS)
    assert np.shares_memory(np.asarray(cloud), cloud.points_xyz)
    assert not np.asarray(cloud).flags.writeable
    copied = np.array(cloud)
    assert copied.flags.writeable
    assert not np.shares_memory(copied, cloud.points_xyz)
    np.testing.assert_array_equal(copied, POINTS)
    assert np.asarray(cloud, dtype=np.float32).dtype == np.float32
    with pytest.raises(ValueError, match="copy"):
        np.array(cloud, dtype=np.float32, copy=False)


@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f4", "<i2"])
def test_fields_x_y_z_are_points(dtype, tmp_path):
    table = structured(100 * POINTS, dtype)
    expected = np.stack([table["x"], table["y"], table["z"]], axis=1)
    np.testing.assert_array_equal(PointCloud(table).points_xyz, expected)
    # An organised cloud has rows and columns of points.
    np.testing.assert_array_equal(PointCloud(table.reshape(5, 10)).points_xyz, expected)
    bounds = CylindricalGrid((4, 8, 4), 500.0, 500.0)
    assert (bounds.hits(table).states == bounds.hits(expected).states).all()
    np.save(tmp_path / "cloud.npy", table)
    np.testing.assert_array_equal(read_cloud(tmp_path / "cloud.npy").points_xyz, expected)
    np.savez(tmp_path / "cloud.npz", points=table)
    np.testing.assert_array_equal(read_cloud(tmp_path / "cloud.npz").points_xyz, expected)


@pytest.mark.parametrize(
    "dtype",
    [
        [("x", "f4"), ("y", "f4")],
        [("x", "f4"), ("y", "f4"), ("z", "U4")],
        [("x", "f4"), ("y", "f4"), ("z", "f4", 3)],
    ],
)
def test_other_fields_are_no_points(dtype, tmp_path):
    table = np.zeros(4, dtype)
    with pytest.raises(GeometryError, match="fields x, y and z"):
        PointCloud(table)
    np.save(tmp_path / "table.npy", table)
    with pytest.raises(InputError, match="fields x, y and z"):
        read_cloud(tmp_path / "table.npy")


@pytest.mark.parametrize(
    "dtype", ["V8", [("x", "f4"), ("y", "f4"), ("z", "f4"), ("any", "O")]], ids=["bytes", "objects"]
)
def test_bytes_and_objects_in_a_file_are_no_points(dtype, tmp_path):
    np.save(tmp_path / "other.npy", np.zeros((4, 3), dtype))
    with pytest.raises(InputError, match=r"numbers are needed|no readable NPY file"):
        read_cloud(tmp_path / "other.npy")


def test_masked_values_are_not_used():
    hidden = np.ma.masked_array(POINTS, mask=np.zeros((50, 3), bool))
    np.testing.assert_array_equal(PointCloud(hidden).points_xyz, POINTS)
    hidden[3] = np.ma.masked
    with pytest.raises(GeometryError, match="drop masked rows first"):
        PointCloud(hidden)
    with pytest.raises(GeometryError, match="drop masked rows first"):
        PointCloud(POINTS, areas=np.ma.masked_less(np.arange(50.0), 3))
    fields = np.ma.masked_array(structured(POINTS))
    fields[3] = np.ma.masked
    with pytest.raises(GeometryError, match="drop masked rows first"):
        PointCloud(fields)
    np.testing.assert_array_equal(PointCloud(np.ma.compress_rows(hidden)), np.delete(POINTS, 3, 0))


@pytest.mark.parametrize("bad", [POINTS + 0j, POINTS > 0, POINTS.astype(str), [["1", "2", "3"]]])
def test_clouds_take_integers_and_floats(bad):
    with pytest.raises(GeometryError, match="an array of numbers is needed, not one of"):
        PointCloud(bad)


def test_a_value_that_is_no_array_is_named_by_type():
    with pytest.raises(GeometryError, match="an array of numbers is needed, not TriangleMesh"):
        PointCloud(MESH)


def test_a_rigid_transform_moves_a_cloud_as_its_matrix_does():
    T = RigidTransform.from_components([1.0, 2.0, 3.0], Rotation.from_rotvec([0.1, 0.2, 0.3]))
    cloud = PointCloud(POINTS, normals_xyz=np.tile([0.0, 0.0, 1.0], (50, 1)))
    moved, expected = cloud.moved(T), cloud.moved(T.as_matrix())
    np.testing.assert_array_equal(moved.points_xyz, expected.points_xyz)
    np.testing.assert_array_equal(moved.normals_xyz, expected.normals_xyz)
    np.testing.assert_allclose(moved.points_xyz, T.apply(POINTS))


def test_reprs_of_shapes_are_short():
    assert repr(PointCloud(POINTS)) == "PointCloud(50 points)"
    full = PointCloud(POINTS, areas=np.ones(50), normals_xyz=POINTS)
    assert repr(full) == "PointCloud(50 points, areas, normals)"
    assert repr(MESH) == "TriangleMesh(3 vertices, 1 faces)"
