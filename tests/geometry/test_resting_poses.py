"""Ways in which objects can stand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import GeometryError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PointCloud
from circumspect.geometry.resting_poses import resting_poses


def box(size, count=4000, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.random((count, 3)) - 0.5
    face = rng.integers(6, size=count)
    points[np.arange(count), face % 3] = np.where(face < 3, -0.5, 0.5)
    return PointCloud(points * size)


def turned(cloud, rotation):
    return cloud.moved(RigidTransform.from_rotation(rotation).as_matrix())


def ups(cloud):
    """The directions of the cloud that the poses bring up."""
    return np.array([pose.inv().apply([0.0, 0.0, 1.0]) for pose in resting_poses(cloud)])


def test_a_box_stands_on_its_six_sides_the_largest_first():
    found = ups(box([1.0, 2.0, 3.0]))
    assert len(found) == 6
    assert np.abs(found).max(axis=1).min() > 0.999
    assert np.abs(found).argmax(axis=1).tolist() == [0, 0, 1, 1, 2, 2]


@given(st.integers(0, 2**20))
def test_the_poses_turn_with_the_object(seed):
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    cloud = box([1.0, 1.7, 2.6], 600)
    still, later = ups(cloud), ups(turned(cloud, rotation))
    nearest = (rotation.apply(still) @ later.T).max(axis=1)
    assert nearest.min() > 0.999


def test_upright_is_among_the_poses_of_nearly_all_furniture():
    """Not of all: some toilets are held up by the floor that they are bolted to."""
    found = []
    for number, category in enumerate(CATEGORIES * 4):
        cloud = make_furniture(category, number).sampled(8000, number)
        rotation = Rotation.random(rng=np.random.default_rng(number))
        up = rotation.apply([0.0, 0.0, 1.0])
        found.append((ups(turned(cloud, rotation)) @ up).max() > np.cos(np.deg2rad(4.0)))
    assert np.mean(found) > 0.94


def test_unstable_faces_are_no_resting_poses():
    """A pin with a heavy head to one side falls from its foot."""
    foot = box([0.2, 0.2, 0.02], 500).points_xyz
    head = box([1.0, 1.0, 0.2], 5000).points_xyz + np.array([0.9, 0.0, 1.0])
    found = ups(PointCloud(np.concatenate([foot, head])))
    assert (found @ [0.0, 0.0, 1.0] < 0.99).all()


def test_a_sheet_lies_on_either_side():
    sheet = PointCloud(np.random.default_rng(0).random((200, 3)) * [1.0, 1.0, 0.0])
    found = ups(sheet)
    np.testing.assert_allclose(np.abs(found), [[0, 0, 1], [0, 0, 1]], atol=1e-9)
    with pytest.raises(GeometryError):
        resting_poses(PointCloud(np.ones((4, 3))))


@given(st.floats(1e-6, 1e6), st.integers(1, 4))
def test_unit_and_place_do_not_matter(scale, most):
    cloud = box([1.0, 2.0, 3.0], 400)
    moved = PointCloud(cloud.points_xyz * scale + 50 * scale)
    one, other = resting_poses(cloud, most), resting_poses(moved, most)
    assert len(one) == most
    for a, b in zip(one, other, strict=True):
        assert (a.inv() * b).magnitude() < 1e-4
