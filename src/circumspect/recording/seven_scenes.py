"""Folders in the layout of Microsoft's 7-Scenes dataset."""

from __future__ import annotations

import logging
import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.recording.frame_folder import GRAVITY_FILE, FrameFolder, read_colour, read_pose
from circumspect.sensing import RgbdFrame

FRAME_RATE = 30.0
"""Frame rate of the Kinect [Hz]; the dataset has no time stamps."""
KINECT_MATRIX = np.array([[585.0, 0.0, 320.0], [0.0, 585.0, 240.0], [0.0, 0.0, 1.0]])
"""Intrinsics of the depth camera according to the dataset, if the folder has none."""
DEPTH_NAME = re.compile(r"frame-(\d+)\.depth\.png")

_log = logging.getLogger(__name__)


class SevenScenesFolder(FrameFolder):
    """Frames of a 7-Scenes folder, in order.

    Files: `frame-NNNNNN.depth.png` (16 bit, millimetres, 0 and 65535 invalid),
    `frame-NNNNNN.pose.txt` (4 x 4, camera to world), and optionally
    `frame-NNNNNN.color.jpg` or `.png`, `camera-intrinsics.txt` (3 x 3) and
    `gravity-direction.txt` (down, in world).

    The map frame has the origin of the poses' world frame and is rotated by the smallest angle so
    that z points up. A frame with a missing or broken depth image or pose is skipped, with the
    reason in `skipped`; a frame with a broken colour image is used without colour.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        every: int = 1,
        poses: bool = True,
        depth_scale: float | None = None,
    ) -> None:
        """Read the layout; frames are read on demand.

        Args:
            path: The folder.
            every: Use every n-th frame only.
            poses: Whether frames carry the recorded poses.
            depth_scale: Metres per unit of the depth images; None for millimetres.

        Raises:
            InputError: No such folder, no frames, broken intrinsics or gravity direction.
        """
        super().__init__(path, every, poses, depth_scale)
        numbered = sorted(
            (int(match.group(1)), file)
            for file in self.path.iterdir()
            if (match := DEPTH_NAME.fullmatch(file.name))
        )
        if not numbered:
            raise InputError(f"{self.path}: contains no frame-*.depth.png")
        self._files = numbered[::every]
        own = self._own_matrix()
        self._matrix = KINECT_MATRIX if own is None else own
        if poses and (turn := self._gravity_alignment()) is not None:
            self.T_map_world = turn
        elif poses:
            file = self.path / GRAVITY_FILE
            _log.warning("%s: missing; the world's z axis is assumed to point up", file)

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
        depth, camera = self._depth_image(depth_file, self._matrix)
        colour = self._colour(stem, (camera.width, camera.height))
        return RgbdFrame(depth, camera, number / FRAME_RATE, T_map_camera, colour)

    def _pose_file(self, depth_file: Path) -> Path:
        return self.path / f"{depth_file.name.removesuffix('.depth.png')}.pose.txt"

    def _colour(self, stem: str, size: tuple[int, int]) -> NDArray[np.uint8] | None:
        for suffix in (".color.jpg", ".color.png"):
            file = self.path / f"{stem}{suffix}"
            if file.is_file() and (colour := read_colour(file, size)) is not None:
                return colour
        return None
