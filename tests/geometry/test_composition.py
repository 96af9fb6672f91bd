import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PlanarPose
from circumspect.geometry.composition import between, composed

changes = st.lists(st.floats(-3, 3), min_size=6, max_size=6)


def pose(change: list[float]) -> RigidTransform:
    return RigidTransform.from_exp_coords(change)


@given(changes, changes, changes)
def test_products_equal_those_of_scipy(
    one: list[float], two: list[float], three: list[float]
) -> None:
    A, B, C = pose(one), pose(two), pose(three)
    assert_allclose(composed(A, B, C).as_matrix(), (A * B * C).as_matrix(), atol=1e-12)
    assert_allclose(between(A, B).as_matrix(), (A.inv() * B).as_matrix(), atol=1e-12)


@given(changes)
def test_a_pose_relative_to_itself_is_the_identity(change: list[float]) -> None:
    T = pose(change)
    assert_allclose(between(T, T).as_matrix(), np.eye(4), atol=1e-12)
    assert_allclose(composed(T).as_matrix(), T.as_matrix())
    assert composed(T, T.inv()).single


def test_rotations_stay_orthonormal_over_a_day_of_frames() -> None:
    step = RigidTransform.from_exp_coords([0.01, -0.02, 0.3, 0.1, 0.0, -0.05])
    T = RigidTransform.identity()
    for _ in range(100_000):
        T = composed(T, step)
    R = T.as_matrix()[:3, :3]
    assert_allclose(R @ R.T, np.eye(3), atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5, np.pi])
def test_a_planar_pose_in_space_turns_about_z(yaw: float) -> None:
    T = PlanarPose(1.0, -2.0, yaw).as_transform()
    assert_allclose(T.translation, [1.0, -2.0, 0.0])
    assert_allclose(T.rotation.as_rotvec(), [0.0, 0.0, yaw], atol=1e-12)
