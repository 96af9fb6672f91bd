"""Base class of folders of recorded frames."""

from __future__ import annotations

import logging
import os
from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError, reason_of
from circumspect.geometry import PinholeCamera
from circumspect.recording.compressed_depth import scaled
from circumspect.recording.recording import Recording
from circumspect.sensing import RgbdFrame
from circumspect.sensing.untrusted_files import opened_picture, require_regular

MAX_FILE_BYTES = 10_000
"""Maximum size of a file with a matrix [bytes]."""
MAX_SIDE_PX = 4096
"""Maximum image side [px]."""
FORMATS = ("PNG", "JPEG")
"""File formats of colour images."""
_log = logging.getLogger(__name__)


INTRINSICS_FILE, GRAVITY_FILE = "camera-intrinsics.txt", "gravity-direction.txt"


class FrameFolder(Recording):
    """RGB-D frames of a folder, in order, read on demand.

    Unreadable frames are skipped; `skipped` holds the reasons.
    """

    DEPTH_SCALE: ClassVar[float] = 1e-3
    """Default scale of the depth images [m per unit]."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        every: int,
        poses: bool,
        depth_scale: float | None = None,
    ) -> None:
        """Check the folder; files are read later.

        Args:
            path: The folder.
            every: Use every n-th frame only.
            poses: Whether frames carry the recorded poses.
            depth_scale: Metres per unit of the depth images; None for the default of the layout.

        Raises:
            InputError: No such folder, or `every` is below 1.
        """
        super().__init__(path, every, poses)
        if not self.path.is_dir():
            raise InputError(f"{self.path}: no such folder of recorded frames")
        self.depth_scale = self.DEPTH_SCALE if depth_scale is None else depth_scale

    @property
    @abstractmethod
    def names(self) -> list[str]:
        """Names of the depth images in order, including broken ones."""

    @property
    @abstractmethod
    def has_poses(self) -> bool:
        """Whether the folder has recorded poses."""

    @abstractmethod
    def read(self, index: int) -> RgbdFrame:
        """Read a frame, with its recorded pose if `poses` is set.

        Raises:
            InputError: The frame cannot be read.
        """

    def __len__(self) -> int:
        """Number of frames, including broken ones."""
        return len(self.names)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames in order.

        Raises:
            InputError: No frame can be read.
        """
        read = 0
        for index, name in enumerate(self.names):
            try:
                frame = self.read(index)
            except InputError as error:
                self.skipped[name] = str(error)
                _log.warning("frame skipped: %s", error)
                continue
            read += 1
            yield frame
        if not read:
            raise InputError(
                f"{self.path}: none of {len(self)} frames can be read; the first: "
                f"{next(iter(self.skipped.values()))}"
            )

    def _depth_image(
        self, file: Path, matrix: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], PinholeCamera]:
        """Depth [m] of a 16-bit file, and the camera."""
        units = read_depth(file)
        height, width = units.shape
        (fx, _, cx), (_, fy, cy), _ = matrix
        if not (cx < width and cy < height):
            raise InputError(
                f"{file}: is {width} x {height}; the principal point ({cx:g}, {cy:g}) of the "
                "intrinsics is outside the image"
            )
        return scaled(units, self.depth_scale), PinholeCamera(width, height, fx, fy, cx, cy)

    def _own_matrix(self) -> NDArray[np.float64] | None:
        """(3, 3) intrinsics from `INTRINSICS_FILE`; None if there is no such file."""
        file = self.path / INTRINSICS_FILE
        return require_matrix(read_numbers(file, 3, 3), file) if file.exists() else None

    def _gravity_alignment(self) -> RigidTransform | None:
        """Rotation that maps the direction in `GRAVITY_FILE` to -z; None without this file."""
        file = self.path / GRAVITY_FILE
        if not file.exists():
            return None
        up = -read_numbers(file, 3)
        if not np.linalg.norm(up) > 0.1:
            raise InputError(f"{file}: is not a direction")
        return RigidTransform.from_rotation(_shortest_turn(up / np.linalg.norm(up)))


def require_matrix(matrix: NDArray[np.float64], file: Path) -> NDArray[np.float64]:
    """Check a camera matrix and return it unchanged.

    Args:
        matrix: (3, 3).
        file: Its file, for the error message.

    Raises:
        InputError: It is not a camera matrix.
    """
    if not (matrix[[0, 1, 0, 1], [0, 1, 2, 2]] > 0).all() or (matrix[2] != [0, 0, 1]).any():
        raise InputError(f"{file}: is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]")
    return matrix


def _shortest_turn(up_xyz: NDArray[np.float64]) -> Rotation:
    """Rotation by the smallest angle that maps a unit vector to +z."""
    axis = np.cross(up_xyz, [0.0, 0.0, 1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(up_xyz[2])
    if sine < 1e-12:
        return Rotation.identity() if cosine > 0 else Rotation.from_rotvec([np.pi, 0.0, 0.0])
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine))


def read_numbers(path: Path, *shape: int) -> NDArray[np.float64]:
    """Read a matrix of whitespace-separated numbers.

    Args:
        path: The file.
        shape: Expected shape.

    Raises:
        InputError: The file is missing, not text, has another count of numbers, or is not finite.
    """
    try:
        require_regular(path)
        with path.open("rb") as stream:
            words = stream.read(MAX_FILE_BYTES).decode("ascii").split()
        numbers = np.array([float(word) for word in words])
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    except ValueError as error:
        raise InputError(f"{path}: contains something other than numbers") from error
    count = int(np.prod(shape))
    if len(numbers) != count:
        raise InputError(f"{path}: contains {len(numbers)} numbers, expected {count}")
    if not np.isfinite(numbers).all():
        raise InputError(f"{path}: contains NaN or infinite numbers")
    return numbers.reshape(shape)


def read_pose(path: Path) -> RigidTransform:
    """Read a 4 x 4 homogeneous transform.

    Raises:
        InputError: See `read_numbers`, or the matrix is not a rigid transform.
    """
    return pose_of(read_numbers(path, 4, 4), path)


def pose_of(matrix: NDArray[np.float64], path: Path) -> RigidTransform:
    """Convert a homogeneous matrix to a pose.

    Args:
        matrix: (4, 4) from a file.
        path: The file, for the error message.

    Raises:
        InputError: The matrix is not a rigid transform, or not finite.
    """
    if not np.isfinite(matrix).all():
        raise InputError(f"{path}: contains NaN or infinite numbers")
    rotation = matrix[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > 0.02 or np.linalg.det(rotation) < 0 or np.abs(matrix[3] - [0, 0, 0, 1]).max() > 1e-6:
        raise InputError(f"{path}: is not a pose: its rotation is not orthonormal")
    rounded = matrix.copy()
    rounded[3] = [0, 0, 0, 1]  # Files round it; a transform requires the exact values.
    return RigidTransform.from_matrix(rounded)


def read_depth(file: Path) -> NDArray[np.uint16]:
    """Read a 16-bit PNG.

    Raises:
        InputError: The file is missing, broken, or not a 16-bit PNG.
    """
    with opened_picture(file, ("PNG",), MAX_SIDE_PX) as image:
        if image.mode not in ("I;16", "I", "I;16B"):
            raise InputError(f"{file}: is not a 16-bit depth image but {image.mode}")
        return np.asarray(image).astype(np.uint16)


def read_colour(
    file: Path, size: tuple[int, int], other_size_is_usual: bool = False
) -> NDArray[np.uint8] | None:
    """Read the optional colour image of a frame; a broken one is logged and skipped.

    Args:
        file: The image.
        size: Required width and height.
        other_size_is_usual: Whether images of another size are skipped without a warning.

    Returns:
        (height, width, 3) RGB, or None.
    """
    try:
        with opened_picture(file, FORMATS, MAX_SIDE_PX) as image:
            if image.size == size:
                return np.asarray(image.convert("RGB"))
            if not other_size_is_usual:
                _log.warning(
                    "colour skipped: %s: its size is %s, that of the depth %s",
                    file,
                    image.size,
                    size,
                )
    except InputError as error:
        _log.warning("colour skipped: %s", error)
    return None
