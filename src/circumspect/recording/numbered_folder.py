"""Folders with numbered images in `depth/`: exported ScanNet scenes and Open3D's layout."""

from __future__ import annotations

import json
import os
import re
from abc import abstractmethod
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError, reason_of
from circumspect.recording.frame_folder import (
    INTRINSICS_FILE,
    FrameFolder,
    pose_of,
    read_colour,
    read_numbers,
    read_pose,
    require_matrix,
)
from circumspect.sensing import RgbdFrame
from circumspect.sensing.untrusted_files import require_regular

DEPTH_FOLDER = "depth"
COLOUR_FOLDERS = ("color", "colour", "image", "rgb")
COLOUR_SUFFIXES = (".jpg", ".png", ".jpeg")
FRAME_RATE = 30.0
"""Frame rate [Hz]; the layouts have no time stamps."""
SCANNET_POSES, SCANNET_INTRINSICS = "pose", Path("intrinsic", "intrinsic_depth.txt")
OPEN3D_INTRINSICS = ("camera_intrinsic.json", "intrinsic.json")
OPEN3D_POSES = (Path("trajectory.log"), Path("scene", "trajectory.log"))
MAX_JSON_BYTES = 100_000
MAX_LOG_BYTES = 100_000_000
"""Maximum sizes of files [bytes]."""
_NUMBER = re.compile(r"(?:.*\D)?(\d{1,9})")


class NumberedFolder(FrameFolder):
    """Frames identified by the numbers of their depth images (16-bit PNG, millimetres).

    The colour image has the same name in `color/`, `image/` or `rgb/` and the size of the depth.
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
            InputError: No such folder, no frames, missing or broken intrinsics, or broken poses.
        """
        super().__init__(path, every, poses, depth_scale)
        self._files = numbered_images(self.path / DEPTH_FOLDER)[::every]
        if not self._files:
            raise InputError(f"{self.path / DEPTH_FOLDER}: contains no numbered PNG images")
        own = self._own_matrix()
        self._matrix = self._layout_matrix() if own is None else own
        if poses and (turn := self._gravity_alignment()) is not None:
            self.T_map_world = turn

    @property
    def names(self) -> list[str]:
        """See `FrameFolder.names`."""
        return [f"{DEPTH_FOLDER}/{file.name}" for _, file in self._files]

    def read(self, index: int) -> RgbdFrame:
        """See `FrameFolder.read`."""
        number, file = self._files[index]
        T_map_camera = self.T_map_world * self._pose(index) if self.poses else None
        depth, camera = self._depth_image(file, self._matrix)
        colour = self._colour(file.stem, (camera.width, camera.height))
        return RgbdFrame(depth, camera, number / FRAME_RATE, T_map_camera, colour)

    @abstractmethod
    def _layout_matrix(self) -> NDArray[np.float64]:
        """(3, 3) intrinsics of the layout.

        Raises:
            InputError: They are missing or broken.
        """

    @abstractmethod
    def _pose(self, index: int) -> RigidTransform:
        """Pose of the camera in the world.

        Raises:
            InputError: The frame has no pose.
        """

    def _colour(self, stem: str, size: tuple[int, int]) -> NDArray[np.uint8] | None:
        for folder in COLOUR_FOLDERS:
            for suffix in COLOUR_SUFFIXES:
                file = self.path / folder / f"{stem}{suffix}"
                if file.is_file():
                    # ScanNet's colour camera has more pixels and another viewpoint.
                    return read_colour(file, size, other_size_is_usual=True)
        return None


class ScanNetFolder(NumberedFolder):
    """A scene as exported by ScanNet's SensReader; z is up.

    Files: `depth/N.png`, `pose/N.txt` (4 x 4, camera to world; -inf where tracking was lost),
    `intrinsic/intrinsic_depth.txt` (4 x 4), where present `color/N.jpg`.
    """

    @property
    def has_poses(self) -> bool:
        """See `FrameFolder.has_poses`."""
        return (self.path / SCANNET_POSES).is_dir()

    def _layout_matrix(self) -> NDArray[np.float64]:
        file = self.path / SCANNET_INTRINSICS
        return require_matrix(read_numbers(file, 4, 4)[:3, :3], file)

    def _pose(self, index: int) -> RigidTransform:
        return read_pose(self.path / SCANNET_POSES / f"{self._files[index][1].stem}.txt")


class Open3dFolder(NumberedFolder):
    """A recording in the layout of Open3D's recorders and reconstruction system.

    Files: `depth/N.png`, `camera_intrinsic.json` or `intrinsic.json` (`intrinsic_matrix` of nine
    numbers, column by column), and optionally `color/N.jpg` and `trajectory.log` or
    `scene/trajectory.log` (camera to world, one pose per frame).
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        every: int = 1,
        poses: bool = True,
        depth_scale: float | None = None,
    ) -> None:
        """See `NumberedFolder`."""
        super().__init__(path, every, poses, depth_scale)
        self._poses: dict[int, RigidTransform] = {}
        if poses and self._log_file is not None:
            self._poses = read_log(self._log_file)

    @property
    def has_poses(self) -> bool:
        """See `FrameFolder.has_poses`."""
        return self._log_file is not None

    @property
    def _log_file(self) -> Path | None:
        return next((self.path / p for p in OPEN3D_POSES if (self.path / p).exists()), None)

    def _layout_matrix(self) -> NDArray[np.float64]:
        for name in OPEN3D_INTRINSICS:
            if (self.path / name).exists():
                return require_matrix(_json_matrix(self.path / name), self.path / name)
        raise InputError(
            f"{self.path}: has no intrinsics; write {INTRINSICS_FILE} "
            f"(fx 0 cx, 0 fy cy, 0 0 1) or {OPEN3D_INTRINSICS[0]} into the folder"
        )

    def _pose(self, index: int) -> RigidTransform:
        number = self._files[index][0]
        if number not in self._poses:
            raise InputError(f"{self._log_file}: contains no pose of frame {number}")
        return self._poses[number]


def numbered_images(folder: Path) -> list[tuple[int, Path]]:
    """PNG images in the order of the numbers at the end of their names."""
    return sorted(
        (int(found.group(1)), file)
        for file in folder.iterdir()
        if file.suffix.lower() == ".png" and (found := _NUMBER.fullmatch(file.stem))
    )


def read_log(path: Path) -> dict[int, RigidTransform]:
    """Read a trajectory in Redwood's format: a line of three numbers, then a 4 x 4 matrix.

    Returns:
        Frame number, from 0, to the pose of the camera in the world.

    Raises:
        InputError: The file cannot be read or is not a trajectory.
    """
    try:
        require_regular(path)
        with path.open("rb") as stream:
            words = stream.read(MAX_LOG_BYTES).split()
        numbers = np.array([float(word) for word in words])
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    except ValueError as error:
        raise InputError(f"{path}: contains something other than numbers") from error
    if not len(numbers) or len(numbers) % 19:
        raise InputError(f"{path}: is not a trajectory of 3 numbers and a 4 x 4 matrix per frame")
    matrices = numbers.reshape(-1, 19)[:, 3:].reshape(-1, 4, 4)
    return {number: pose_of(matrix, path) for number, matrix in enumerate(matrices)}


def _json_matrix(path: Path) -> NDArray[np.float64]:
    """(3, 3) of Open3D's `PinholeCameraIntrinsic`."""
    try:
        require_regular(path)
        with path.open("rb") as stream:
            document = json.loads(stream.read(MAX_JSON_BYTES))
        columns = np.array(document["intrinsic_matrix"], np.float64).reshape(3, 3)
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise InputError(f"{path}: contains no 'intrinsic_matrix' of nine numbers") from error
    return columns.T
