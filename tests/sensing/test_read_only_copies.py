"""What can not be written to stays so when it is copied or comes from another process."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from circumspect.geometry import PinholeCamera, PlanarPose, PointCloud, Trajectory, TriangleMesh
from circumspect.grid import CylindricalGrid
from circumspect.sensing import Odometry, RgbdFrame

ODOMETRY = Odometry(0.0, PlanarPose(1.0, 2.0, 3.0), np.eye(3))
VALUES = [
    PointCloud(np.eye(3), areas=np.ones(3), normals_xyz=np.eye(3)),
    TriangleMesh(np.eye(3), np.array([[0, 1, 2]])),
    Trajectory(np.arange(2.0), RigidTransform.identity(2)),
    CylindricalGrid((2, 3, 4)).hits(np.zeros((1, 3))),
    ODOMETRY,
    RgbdFrame(
        np.ones((3, 4)), PinholeCamera(4, 3, 5, 5, 2, 1), 0.0, colour=np.zeros((3, 4, 3), np.uint8),
        odometry=ODOMETRY,
    ),
]  # fmt: skip


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize(
    "travel",
    [*(lambda v, n=n: pickle.loads(pickle.dumps(v, n)) for n in range(2, 6)), copy.deepcopy],
)
def test_copies_are_as_read_only(value, travel):
    copied = travel(value)
    arrays = 0
    for field in dataclasses.fields(value):
        original, same = getattr(value, field.name), getattr(copied, field.name)
        if isinstance(original, np.ndarray):
            arrays += 1
            assert not same.flags.writeable, field.name
            np.testing.assert_array_equal(same, original)
    assert arrays
    if isinstance(copied, RgbdFrame):
        assert not copied.odometry.covariance.flags.writeable
