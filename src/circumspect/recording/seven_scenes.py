"""Folders in the layout of Microsoft's 7-Scenes data set."""

from __future__ import annotations

import logging
import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.frame_folder import FrameFolder
from circumspect.recording.image_files import read_colour, read_depth
from circumspect.recording.matrix_file import read_numbers, read_pose
from circumspect.sensing import RgbdFrame

FRAME_RATE = 30.0
"""The Kinect's frames a second; the data set has no time stamps."""
KINECT_MATRIX = np.array([[585.0, 0.0, 320.0], [0.0, 585.0, 240.0], [0.0, 0.0, 1.0]])
"""Intrinsics the data set states for its depth camera, where the folder holds none."""
DEPTH_NAME = re.compile(r"frame-(\d+)\.depth\.png")

_log = logging.getLogger(__name__)


class SevenScenesFolder(FrameFolder):
    """The frames of a folder, in order.

    Files: `frame-NNNNNN.depth.png` (16 bit, millimetres, 0 and 65535 invalid),
    `frame-NNNNNN.pose.txt` (4 x 4, camera to world), and where present
    `frame-NNNNNN.color.jpg` or `.png`, `camera-intrinsics.txt` (3 x 3) and
    `gravity-direction.txt` (down, in world).

    The map frame is the world frame of the poses, with the same origin, turned the shortest way
    so that z points up. A frame with a missing or broken depth image or pose is left out and the
    reason kept in `skipped`; a broken colour image costs only the colour.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        every: int = 1,
        poses: bool = True,
    ) -> None:
        """Look the folder over; frames are read when they are asked for.

        Args:
            path: The folder.
            every: Take each n-th frame only.
            poses: Whether frames bring the recorded poses along.

        Raises:
            InputError: No such folder, no frames in it, broken intrinsics or gravity direction.
        """
        super().__init__(path, every, poses)
        numbered = sorted(
            (int(match.group(1)), file)
            for file in self.path.iterdir()
            if (match := DEPTH_NAME.fullmatch(file.name))
        )
        if not numbered:
            raise InputError(f"{self.path}: holds no frame-*.depth.png")
        self._files = numbered[::every]
        self._matrix = self._camera_matrix(KINECT_MATRIX)
        if poses:
            self.T_map_world = self._upright()

    @property
    def names(self) -> list[str]:
        """See `FrameFolder.names`."""
        return [file.name for _, file in self._files]

    @property
    def has_poses(self) -> bool:
        """See `FrameFolder.has_poses`."""
        return any(self._pose_file(file).exists() for _, file in self._files)

    def read(self, index: int) -> RgbdFrame:
        """See `FrameFolder.read`."""
        number, depth_file = self._files[index]
        stem = depth_file.name.removesuffix(".depth.png")
        T_map_camera = None
        if self.poses:
            T_map_camera = self.T_map_world * read_pose(self._pose_file(depth_file))
        millimetres = read_depth(depth_file)
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
            millimetres, camera, number / FRAME_RATE, T_map_camera, colour
        )

    def _pose_file(self, depth_file: Path) -> Path:
        return self.path / f"{depth_file.name.removesuffix('.depth.png')}.pose.txt"

    def _colour(self, stem: str, size: tuple[int, int]) -> NDArray[np.uint8] | None:
        for suffix in (".color.jpg", ".color.png"):
            file = self.path / f"{stem}{suffix}"
            if file.is_file() and (colour := read_colour(file, size)) is not None:
                return colour
        return None

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
