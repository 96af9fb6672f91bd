import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.errors import GeometryError
from circumspect.geometry import PlanarPose

lengths = st.floats(-50, 50)
poses = st.builds(PlanarPose, lengths, lengths, st.floats(-20, 20))


def assert_same(a: PlanarPose, b: PlanarPose) -> None:
    np.testing.assert_allclose(
        a.as_transform().as_matrix(), b.as_transform().as_matrix(), atol=1e-9
    )


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    assert_same((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_inverse_composes_to_the_identity(pose):
    assert_same(pose @ pose.inverse(), PlanarPose())
    assert_same(pose.inverse() @ pose, PlanarPose())


@given(poses, poses)
def test_composition_agrees_with_rigid_transforms(a, b):
    in_space = a.as_transform() * b.as_transform()
    assert_same(PlanarPose.from_transform(in_space), a @ b)


@given(poses, st.lists(st.tuples(lengths, lengths), min_size=1, max_size=5))
def test_points_move_as_in_space(pose, points):
    points_xy = np.array(points)
    in_space = pose.as_transform().apply(np.column_stack([points_xy, np.zeros(len(points_xy))]))
    np.testing.assert_allclose(pose.applied(points_xy), in_space[:, :2], atol=1e-9)


@given(st.floats(-100, 100))
def test_yaw_is_kept_within_one_turn(yaw):
    kept = PlanarPose(0, 0, yaw).yaw
    assert -np.pi < kept <= np.pi + 1e-12
    np.testing.assert_allclose([np.cos(kept), np.sin(kept)], [np.cos(yaw), np.sin(yaw)], atol=1e-9)


def test_height_and_tilt_are_dropped():
    tilted = RigidTransform.from_components(
        [1, 2, 3], PlanarPose(0, 0, 0.5).as_transform().rotation
    )
    assert_same(PlanarPose.from_transform(tilted), PlanarPose(1, 2, 0.5))


@pytest.mark.parametrize("values", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, np.nan)])
def test_values_that_are_not_finite_are_refused(values):
    with pytest.raises(GeometryError, match="finite"):
        PlanarPose(*values)
