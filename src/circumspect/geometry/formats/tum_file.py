"""Trajectories as TUM RGB-D text: a line `stamp tx ty tz qx qy qz qw` per pose."""

from __future__ import annotations

import logging
import os

import numpy as np

from circumspect.errors import GeometryError, InputError
from circumspect.geometry.formats.file_errors import reading_file
from circumspect.geometry.formats.number_table import read_table
from circumspect.geometry.trajectory import Trajectory
from circumspect.storage import atomic_open

_UNIT_TOLERANCE = 1e-3

_log = logging.getLogger(__name__)


def write_tum(path: str | os.PathLike[str], trajectory: Trajectory) -> None:
    """Write stamps [s], positions [m] and quaternions (xyzw) with all digits.

    Raises:
        OutputError: The file cannot be written.
    """
    poses = trajectory.T_map_camera
    table = np.column_stack(
        [trajectory.stamps, poses.translation, poses.rotation.as_quat(canonical=True)]
    )
    with atomic_open(path) as stream:
        stream.write("# stamp tx ty tz qx qy qz qw\n")
        stream.writelines(" ".join(map(repr, row)) + "\n" for row in table.tolist())


def read_tum(path: str | os.PathLike[str]) -> Trajectory:
    """Read a trajectory; lines beginning with # are comments.

    Poses that are not finite are left out, and their number is logged.

    Raises:
        InputError: The file cannot be read, or is no such table.
        GeometryError: Stamps that do not increase, or quaternions far from unit length.
    """
    from scipy.spatial.transform import RigidTransform, Rotation

    with reading_file(path) as file, file.open("rb") as stream:
        table = read_table(stream, comments="#")
        if table.shape[1] != 8:
            raise InputError(f"needs 8 columns (stamp tx ty tz qx qy qz qw), has {table.shape[1]}")
        finite = np.isfinite(table).all(axis=1)
        if not finite.any():
            raise GeometryError("holds no pose that is finite, but NaN or infinite values")
        if not finite.all():
            lost = len(table) - int(finite.sum())
            _log.warning("%s: %d of %d poses left out: not finite", path, lost, len(table))
        table = table[finite]
        quaternions = table[:, 4:]
        off = np.abs(np.linalg.norm(quaternions, axis=1) - 1) > _UNIT_TOLERANCE
        if off.any():
            raise GeometryError(
                f"{int(off.sum())} of {len(table)} quaternions are not of unit length; "
                "the order is qx qy qz qw"
            )
        poses = RigidTransform.from_components(table[:, 1:4], Rotation.from_quat(quaternions))
        return Trajectory(table[:, 0], poses)
