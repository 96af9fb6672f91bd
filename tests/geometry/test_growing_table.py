from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import TrajectoryLog
from circumspect.geometry.growing_table import BLOCK, GrowingTable


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK])
def test_rows_are_returned_in_order(count: int) -> None:
    rows = np.random.default_rng(count).normal(size=(count, 5))
    table = GrowingTable(5)
    for row in rows:
        table.append(row)
    assert len(table) == count
    np.testing.assert_array_equal(table.rows, rows)


def test_returned_rows_are_copies() -> None:
    table = GrowingTable(4)
    table.append(np.eye(2))
    before = table.rows
    before[:] = 7
    table.append([5, 6, 7, 8])
    np.testing.assert_array_equal(table.rows, [[1, 0, 0, 1], [5, 6, 7, 8]])


@pytest.mark.parametrize("row", [[], [1, 2], [1, 2, 3, 4]])
def test_a_row_of_another_length_is_refused(row: list[float]) -> None:
    table = GrowingTable(3)
    with pytest.raises(ValueError, match="reshape"):
        table.append(row)
    assert len(table) == 0


def test_poses_are_kept_to_the_last_bit() -> None:
    rng = np.random.default_rng(1)
    poses = [
        RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
        for _ in range(300)
    ]
    # A product is no longer orthonormal to the last bit, and must not be made so.
    poses = [one * other for one, other in pairwise(poses)]
    log = TrajectoryLog()
    for number, pose in enumerate(poses):
        log.add(0.1 * number, pose)
    path = log.trajectory
    assert path is not None
    np.testing.assert_array_equal(
        path.T_map_camera.as_matrix(), [pose.as_matrix() for pose in poses]
    )


def test_poses_that_come_late_or_twice_are_left_out() -> None:
    log = TrajectoryLog()
    assert log.trajectory is None
    for stamp in (0.0, 1.0, 0.5, 1.0, 2.0):
        log.add(stamp, RigidTransform.from_translation([stamp, 0, 0]))
    assert len(log) == 3
    path = log.trajectory
    assert path is not None
    np.testing.assert_array_equal(path.stamps, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(path.positions_xyz[:, 0], [0.0, 1.0, 2.0])
