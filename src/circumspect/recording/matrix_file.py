"""Small matrices in text files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError, reason_of
from circumspect.sensing.regular_file import require_regular

LARGEST_FILE = 10_000
"""Longer files are no matrix of a few numbers [bytes]."""


def read_numbers(path: Path, *shape: int) -> NDArray[np.float64]:
    """Read a matrix of numbers separated by white space.

    Args:
        path: The file.
        shape: What is expected.

    Raises:
        InputError: Missing, not text, other numbers than expected, or not finite.
    """
    try:
        require_regular(path)
        with path.open("rb") as stream:
            words = stream.read(LARGEST_FILE).decode("ascii").split()
        numbers = np.array([float(word) for word in words])
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    except ValueError as error:
        raise InputError(f"{path}: holds something else than numbers") from error
    count = int(np.prod(shape))
    if len(numbers) != count:
        raise InputError(f"{path}: holds {len(numbers)} numbers, expected {count}")
    if not np.isfinite(numbers).all():
        raise InputError(f"{path}: holds NaN or infinite numbers")
    return numbers.reshape(shape)


def read_pose(path: Path) -> RigidTransform:
    """Read a 4 x 4 homogeneous transform.

    Raises:
        InputError: As `read_numbers`, or the matrix is no rotation and translation.
    """
    return pose_of(read_numbers(path, 4, 4), path)


def pose_of(matrix: NDArray[np.float64], path: Path) -> RigidTransform:
    """The pose that a homogeneous transform is.

    Args:
        matrix: (4, 4), as a file has it.
        path: The file, for the message.

    Raises:
        InputError: It is no rotation and translation, or not finite.
    """
    if not np.isfinite(matrix).all():
        raise InputError(f"{path}: holds NaN or infinite numbers")
    rotation = matrix[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > 0.02 or np.linalg.det(rotation) < 0 or np.abs(matrix[3] - [0, 0, 0, 1]).max() > 1e-6:
        raise InputError(f"{path}: is no pose: its rotation is not orthonormal")
    rounded = matrix.copy()
    rounded[3] = [0, 0, 0, 1]  # Files round it; a transform takes nothing but this.
    return RigidTransform.from_matrix(rounded)
