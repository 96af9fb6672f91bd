"""Laws of the camera and of trajectories."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PinholeCamera, Trajectory, read_tum, write_tum


@given(seed=st.integers(0, 2**32 - 1))
def test_projection_inverts_back_projection(seed: int):
    rng = np.random.default_rng(seed)
    width, height = rng.integers(1, 40, 2).tolist()
    camera = PinholeCamera(width, height, *rng.uniform(5, 500, 2), *rng.uniform(-50, 50, 2))
    depth = rng.uniform(0.1, 10, (height, width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.3] = np.nan
    mask = rng.random(depth.shape) < 0.7
    points = camera.back_project(depth, mask)
    v, u = np.nonzero(np.isfinite(depth) & mask)
    np.testing.assert_allclose(points[:, 2], depth[v, u])
    np.testing.assert_allclose(camera.project(points), np.stack([u, v], axis=1), atol=1e-6)
    np.testing.assert_allclose(points, camera.rays_xyz[v, u] * depth[v, u, None], atol=1e-12)


def test_optical_frame():
    camera = PinholeCamera.xtion()
    assert (camera.width, camera.height, camera.fx) == (640, 480, 570.3)
    rays = camera.rays_xyz
    assert rays.shape == (480, 640, 3)
    assert rays[0, 0, 0] < 0 < rays[0, -1, 0]  # x to the right
    assert rays[0, 0, 1] < 0 < rays[-1, 0, 1]  # y down
    field_of_view = (
        np.degrees(2 * np.arctan(rays[0, -1, 0])),
        np.degrees(2 * np.arctan(rays[-1, 0, 1])),
    )
    np.testing.assert_allclose(field_of_view, (58, 45), atol=1)


def test_images_without_valid_depth_give_no_points():
    camera = PinholeCamera(4, 3, 2.0, 2.0, 1.5, 1.0)
    assert camera.back_project(np.full((3, 4), np.nan)).shape == (0, 3)
    assert camera.project(np.empty((0, 3))).shape == (0, 2)


def test_points_behind_the_camera_are_not_seen():
    pixels = PinholeCamera.xtion().project([[0, 0, -1], [0, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(np.isnan(pixels[:, 0]), [True, True, False])


@pytest.mark.parametrize(
    "numbers",
    [(0, 1, 1, 1, 0, 0), (1, 1, 0, 1, 0, 0), (1, 1, 1, np.nan, 0, 0), (1, 1, 1, 1, np.inf, 0)],
)
def test_bad_cameras(numbers: tuple):
    with pytest.raises(GeometryError):
        PinholeCamera(*numbers)


def test_images_of_other_sizes_are_refused():
    camera = PinholeCamera(4, 3, 2.0, 2.0, 1.5, 1.0)
    with pytest.raises(GeometryError, match=r"depth must have shape \(3, 4\), not \(4, 3\)"):
        camera.back_project(np.ones((4, 3)))
    with pytest.raises(GeometryError, match="mask must have shape"):
        camera.back_project(np.ones((3, 4)), np.ones((4, 3), bool))


def random_trajectory(rng: np.random.Generator, count: int = 20) -> Trajectory:
    poses = RigidTransform.from_components(
        rng.normal(size=(count, 3)), Rotation.random(count, rng=rng)
    )
    return Trajectory(1.7e9 + np.cumsum(rng.uniform(1e-3, 1, count)), poses)


def test_tum_round_trip(tmp_path: Path):
    trajectory = random_trajectory(np.random.default_rng(0))
    write_tum(tmp_path / "new" / "camera.txt", trajectory)
    again = read_tum(tmp_path / "new" / "camera.txt")
    np.testing.assert_array_equal(again.stamps, trajectory.stamps)
    np.testing.assert_array_equal(again.positions_xyz, trajectory.positions_xyz)
    np.testing.assert_allclose(
        again.T_map_camera.as_matrix(), trajectory.T_map_camera.as_matrix(), atol=1e-14
    )


def test_tum_order_is_scalar_last(tmp_path: Path):
    (tmp_path / "a.txt").write_text("# c\n1.5 1 2 3 0 0 0.7071067811865476 0.7071067811865476\n")
    pose = read_tum(tmp_path / "a.txt").T_map_camera[0]
    # A quarter turn about z takes x to y.
    np.testing.assert_allclose(pose.apply([1, 0, 0]), [1, 3, 3], atol=1e-12)


def test_moving_a_trajectory_is_a_group_action():
    rng = np.random.default_rng(1)
    trajectory = random_trajectory(rng)
    first, second = random_trajectory(rng, 2).T_map_camera
    one, two = trajectory.moved(first).moved(second), trajectory.moved(second * first)
    np.testing.assert_allclose(
        one.T_map_camera.as_matrix(), two.T_map_camera.as_matrix(), atol=1e-12
    )
    back = trajectory.moved(first).moved(first.inv())
    np.testing.assert_allclose(back.positions_xyz, trajectory.positions_xyz, atol=1e-12)


@pytest.mark.parametrize(
    ("stamps", "word"),
    [
        ([0.0, 1.0, 1.0], "number 2 is 1 s after 1 s"),
        ([0.0, 2.0, 1.0], "increase strictly"),
        ([0.0, np.nan, 1.0], "NaN"),
        ([0.0, 1.0], "2 stamps need as many poses in a batch, not 3"),
        ([[0.0, 1.0, 2.0]], "shape"),
    ],
)
def test_bad_stamps(stamps: list, word: str):
    with pytest.raises(GeometryError, match=word):
        Trajectory(np.array(stamps), RigidTransform.identity(3))


def test_a_trajectory_needs_a_batch_of_poses():
    with pytest.raises(GeometryError, match="batch"):
        Trajectory(np.zeros(1), RigidTransform.identity())


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("# only comments\n", "holds no numbers"),
        ("0 1 2 3 0 0 0\n", "needs 8 columns"),
        ("0 1 2 3 0 0 0 x\n", "broken table"),
        ("0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0\n", "broken table"),
        ("0 1 2 3 0 0 0 0\n", "unit length; the order is qx qy qz qw"),
        ("0 1 2 nan 0 0 0 1\n", "NaN"),
        ("1 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n", "increase strictly"),
    ],
)
def test_bad_tum_files(text: str, word: str, tmp_path: Path):
    path = tmp_path / "a.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=word) as error:
        read_tum(path)
    assert str(error.value).startswith(f"{path}: ")
    with pytest.raises(InputError, match="does not exist"):
        read_tum(tmp_path / "b.txt")


def test_poses_are_rigid_transforms():
    matrices = np.tile(np.eye(4), (2, 1, 1))
    with pytest.raises(InputError, match=r"T_map_camera must be .* RigidTransform\.from_matrix"):
        Trajectory(np.arange(2.0), matrices)
    path = Trajectory(np.arange(2.0), RigidTransform.from_matrix(matrices))
    with pytest.raises(InputError, match="T_target_map must be a SciPy RigidTransform"):
        path.moved(np.eye(4))
