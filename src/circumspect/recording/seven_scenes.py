"""Folders in the layout of Microsoft's 7-Scenes data set."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.matrix_file import read_numbers, read_pose
from circumspect.sensing import RgbdFrame

FRAME_RATE = 30.0
"""The Kinect's frames a second; the data set has no time stamps."""
KINECT_MATRIX = np.array([[585.0, 0.0, 320.0], [0.0, 585.0, 240.0], [0.0, 0.0, 1.0]])
"""Intrinsics the data set states for its depth camera, where the folder holds none."""
_DEPTH_NAME = re.compile(r"frame-(\d+)\.depth\.png")

_log = logging.getLogger(__name__)


class SevenScenesFolder:
    """The frames of a folder, in order.

    Files: `frame-NNNNNN.depth.png` (16 bit, millimetres, 0 and 65535 invalid),
    `frame-NNNNNN.pose.txt` (4 x 4, camera to world), and where present
    `frame-NNNNNN.color.jpg` or `.png`, `camera-intrinsics.txt` (3 x 3) and
    `gravity-direction.txt` (down, in world).

    The map frame is the world frame of the poses, with the same origin, turned the shortest way
    so that z points up. A frame with a missing or broken depth image or pose is left out and the
    reason kept in `skipped`; a broken colour image costs only the colour.
    """

    def __init__(self, path: str | os.PathLike[str], every: int = 1) -> None:
        """Look the folder over; frames are read when they are asked for.

        Args:
            path: The folder.
            every: Take each n-th frame only.

        Raises:
            InputError: No such folder, no frames in it, broken intrinsics or gravity direction.
        """
        self.path = Path(path)
        if every < 1:
            raise InputError(f"every {every}: take each first, second, … frame")
        if not self.path.is_dir():
            raise InputError(f"{self.path}: no such folder; give one with frame-*.depth.png")
        numbered = sorted(
            (int(match.group(1)), file)
            for file in self.path.iterdir()
            if (match := _DEPTH_NAME.fullmatch(file.name))
        )
        if not numbered:
            raise InputError(f"{self.path}: holds no frame-*.depth.png")
        self._files = numbered[::every]
        self._matrix = self._intrinsics()
        self.T_map_world = self._upright()
        """Turns the world frame of the poses into the map frame."""
        self.skipped: dict[str, str] = {}
        """File name to reason, of the frames left out so far."""

    def __len__(self) -> int:
        """How many frames there are, broken ones included."""
        return len(self._files)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Read the frames one after the other.

        Raises:
            InputError: Not a single frame can be read.
        """
        read = 0
        for number, depth_file in self._files:
            try:
                frame = self._frame(number, depth_file)
            except InputError as error:
                self.skipped[depth_file.name] = str(error)
                _log.warning("frame left out: %s", error)
                continue
            read += 1
            yield frame
        if not read:
            raise InputError(
                f"{self.path}: none of {len(self)} frames can be read; the first: "
                f"{next(iter(self.skipped.values()))}"
            )

    def _frame(self, number: int, depth_file: Path) -> RgbdFrame:
        stem = depth_file.name.removesuffix(".depth.png")
        T_world_camera = read_pose(self.path / f"{stem}.pose.txt")
        millimetres = _read_depth(depth_file)
        height, width = millimetres.shape
        (fx, _, cx), (_, fy, cy), _ = self._matrix
        if not (cx < width and cy < height):
            raise InputError(
                f"{depth_file}: is {width} x {height}; the principal point ({cx:g}, {cy:g}) of "
                "the intrinsics lies outside"
            )
        camera = PinholeCamera(width, height, fx, fy, cx, cy)
        colour = self._colour(stem, (width, height))
        return RgbdFrame.from_millimetres(
            millimetres, camera, number / FRAME_RATE, self.T_map_world * T_world_camera, colour
        )

    def _colour(self, stem: str, size: tuple[int, int]) -> NDArray[np.uint8] | None:
        from PIL import Image

        for suffix in (".color.jpg", ".color.png"):
            file = self.path / f"{stem}{suffix}"
            if not file.is_file():
                continue
            try:
                with Image.open(file) as image:
                    if image.size == size:
                        return np.asarray(image.convert("RGB"))
                    _log.warning("colour left out: %s: is %s, the depth %s", file, image.size, size)
            except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
                _log.warning("colour left out: %s: %s", file, error)
        return None

    def _intrinsics(self) -> NDArray[np.float64]:
        file = self.path / "camera-intrinsics.txt"
        if not file.exists():
            return KINECT_MATRIX
        matrix = read_numbers(file, 3, 3)
        if not (matrix[[0, 1, 0, 1], [0, 1, 2, 2]] > 0).all() or (matrix[2] != [0, 0, 1]).any():
            raise InputError(f"{file}: is no camera matrix [fx 0 cx; 0 fy cy; 0 0 1]")
        return matrix

    def _upright(self) -> RigidTransform:
        file = self.path / "gravity-direction.txt"
        if not file.exists():
            _log.warning("%s: missing; the world's z is taken for up", file)
            return RigidTransform.identity()
        up = -read_numbers(file, 3)
        if not np.linalg.norm(up) > 0.1:
            raise InputError(f"{file}: is no direction")
        return RigidTransform.from_rotation(_shortest_turn(up / np.linalg.norm(up)))


def _shortest_turn(up_xyz: NDArray[np.float64]) -> Rotation:
    """The rotation by the smallest angle that takes a unit vector to +z."""
    axis = np.cross(up_xyz, [0.0, 0.0, 1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(up_xyz[2])
    if sine < 1e-12:
        return Rotation.identity() if cosine > 0 else Rotation.from_rotvec([np.pi, 0.0, 0.0])
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine))


def _read_depth(file: Path) -> NDArray[np.uint16]:
    from PIL import Image

    try:
        with Image.open(file) as image:
            if image.format != "PNG" or image.mode not in ("I;16", "I", "I;16B"):
                raise InputError(f"{file}: is no 16 bit depth image but {image.mode}")
            return np.asarray(image).astype(np.uint16)
    # Pillow reports broken files by any of these.
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(f"{file}: can not be read ({error})") from error
