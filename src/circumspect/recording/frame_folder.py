"""What all folders of recorded frames have in common."""

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

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.compressed_depth import scaled
from circumspect.recording.image_files import read_depth
from circumspect.recording.matrix_file import read_numbers
from circumspect.recording.recording import Recording
from circumspect.sensing import RgbdFrame

INTRINSICS_FILE, GRAVITY_FILE = "camera-intrinsics.txt", "gravity-direction.txt"

_log = logging.getLogger(__name__)


class FrameFolder(Recording):
    """RGB-D frames of a folder, in order, read when they are asked for.

    A frame that can not be read is left out and the reason kept in `skipped`.
    """

    DEPTH_SCALE: ClassVar[float] = 1e-3
    """Metres a unit of the depth images, where nobody says otherwise."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        every: int,
        poses: bool,
        depth_scale: float | None = None,
    ) -> None:
        """Check what needs no look into files.

        Args:
            path: The folder.
            every: Take each n-th frame only.
            poses: Whether frames bring the recorded poses along.
            depth_scale: Metres a unit of the depth images; None for that of the layout.

        Raises:
            InputError: No such folder, or `every` is below 1.
        """
        super().__init__(path)
        if every < 1:
            raise InputError(f"every {every}: take each first, second, … frame")
        if not self.path.is_dir():
            raise InputError(f"{self.path}: no such folder; give one of recorded frames")
        self.every = every
        self.poses = poses
        self.depth_scale = self.DEPTH_SCALE if depth_scale is None else depth_scale

    @property
    @abstractmethod
    def names(self) -> list[str]:
        """Of the depth images, in order, broken ones included."""

    @property
    @abstractmethod
    def has_poses(self) -> bool:
        """Whether poses were recorded at all."""

    @abstractmethod
    def read(self, index: int) -> RgbdFrame:
        """One frame, with its recorded pose unless no poses are wanted.

        Raises:
            InputError: It can not be read.
        """

    def __len__(self) -> int:
        """How many frames there are, broken ones included."""
        return len(self.names)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames one after the other.

        Raises:
            InputError: Not a single frame can be read.
        """
        read = 0
        for index, name in enumerate(self.names):
            try:
                frame = self.read(index)
            except InputError as error:
                self.skipped[name] = str(error)
                _log.warning("frame left out: %s", error)
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
        """Depth [m] of a file of 16 bits, and the camera that took it."""
        units = read_depth(file)
        height, width = units.shape
        (fx, _, cx), (_, fy, cy), _ = matrix
        if not (cx < width and cy < height):
            raise InputError(
                f"{file}: is {width} x {height}; the principal point ({cx:g}, {cy:g}) of the "
                "intrinsics lies outside"
            )
        return scaled(units, self.depth_scale), PinholeCamera(width, height, fx, fy, cx, cy)

    def _own_matrix(self) -> NDArray[np.float64] | None:
        """(3, 3) from the folder's own file; None where it has none."""
        file = self.path / INTRINSICS_FILE
        return require_matrix(read_numbers(file, 3, 3), file) if file.exists() else None

    def _upright(self) -> RigidTransform | None:
        """The turn that takes the direction of the folder's own file to -z; None without a file."""
        file = self.path / GRAVITY_FILE
        if not file.exists():
            return None
        up = -read_numbers(file, 3)
        if not np.linalg.norm(up) > 0.1:
            raise InputError(f"{file}: is no direction")
        return RigidTransform.from_rotation(_shortest_turn(up / np.linalg.norm(up)))


def require_matrix(matrix: NDArray[np.float64], file: Path) -> NDArray[np.float64]:
    """A camera matrix, as it is.

    Args:
        matrix: (3, 3).
        file: Where it is from, for the message.

    Raises:
        InputError: It is none.
    """
    if not (matrix[[0, 1, 0, 1], [0, 1, 2, 2]] > 0).all() or (matrix[2] != [0, 0, 1]).any():
        raise InputError(f"{file}: is no camera matrix [fx 0 cx; 0 fy cy; 0 0 1]")
    return matrix


def _shortest_turn(up_xyz: NDArray[np.float64]) -> Rotation:
    """The rotation by the smallest angle that takes a unit vector to +z."""
    axis = np.cross(up_xyz, [0.0, 0.0, 1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(up_xyz[2])
    if sine < 1e-12:
        return Rotation.identity() if cosine > 0 else Rotation.from_rotvec([np.pi, 0.0, 0.0])
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine))
