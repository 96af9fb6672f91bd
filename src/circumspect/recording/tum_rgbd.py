"""Folders in the layout of the TUM RGB-D benchmark."""

from __future__ import annotations

import logging
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Slerp

from circumspect.errors import InputError, reason_of
from circumspect.geometry import Trajectory, read_tum
from circumspect.recording.frame_folder import (
    INTRINSICS_FILE,
    FrameFolder,
    read_colour,
    read_numbers,
    require_matrix,
)
from circumspect.sensing import RgbdFrame
from circumspect.sensing.untrusted_files import require_regular

DEPTH_LIST, COLOUR_LIST, POSE_LIST = "depth.txt", "rgb.txt", "groundtruth.txt"
CALIBRATION_FILE = "calibration.txt"
"""Contains fx fy cx cy in ETH3D's RGB-D benchmark, which has the same layout."""
MAX_STAMP_DIFFERENCE_S = 0.02
"""Maximum difference between the stamps of depth, colour and pose [s]."""
MAX_INTERPOLATION_GAP_S = 0.05
"""Maximum time between two poses that are interpolated [s]."""
MAX_LIST_BYTES = 50_000_000
"""Maximum size of a list of images [bytes]."""
# fx, fy, cx, cy of the benchmark's colour cameras, to which depth is registered.
_FREIBURG_INTRINSICS = {
    "1": (517.3, 516.5, 318.6, 255.3),
    "2": (520.9, 521.0, 325.1, 249.7),
    "3": (535.4, 539.2, 320.1, 247.6),
}
_DEFAULT_INTRINSICS = (525.0, 525.0, 319.5, 239.5)

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class StampedFile:
    """An entry of a list of images.

    Attributes:
        stamp: Time [s].
        name: Path inside the folder.
    """

    stamp: float
    name: str


class TumRgbdFolder(FrameFolder):
    """Frames of a TUM RGB-D folder, in the order of their stamps.

    Files:

    - `depth.txt`: lines `stamp file`; 16-bit images, by default 5000 units per metre, 0 and 65535
      invalid.
    - `rgb.txt` (optional): the same for colour images.
    - `groundtruth.txt` (optional): lines `stamp tx ty tz qx qy qz qw`, camera to world.
    - `gravity-direction.txt` (optional): down in world, if z is not up as in the benchmark.
    - `camera-intrinsics.txt` (3 x 3) or `calibration.txt` (`fx fy cx cy`, as in ETH3D): optional.

    Without intrinsics the benchmark's values for freiburg1, 2 or 3 are used, according to the
    folder's name.

    A frame has the colour image nearest in time and a pose interpolated between the nearest two. If
    there is a `groundtruth.txt`, frames without a pose within 20 ms are skipped; without the file
    frames have no poses. `skipped` holds the reasons.
    """

    DEPTH_SCALE: ClassVar[float] = 1 / 5000

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
            depth_scale: Metres per unit of the depth images; None for 1/5000.

        Raises:
            InputError: No such folder, no depth images, or broken poses, intrinsics or gravity
                direction.
        """
        super().__init__(path, every, poses, depth_scale)
        self._depth = read_list(self.path / DEPTH_LIST)[::every]
        colour = self.path / COLOUR_LIST
        self._colour = read_list(colour) if colour.exists() else []
        self._colour_stamps = np.array([file.stamp for file in self._colour])
        if poses and (turn := self._gravity_alignment()) is not None:
            self.T_map_world = turn
        self.truth = self._truth()
        """Recorded poses in the map frame; None if there are none."""
        own = self._own_matrix()
        self._matrix = self._layout_matrix() if own is None else own

    @property
    def names(self) -> list[str]:
        """See `FrameFolder.names`."""
        return [file.name for file in self._depth]

    @property
    def has_poses(self) -> bool:
        """See `FrameFolder.has_poses`."""
        return self.truth is not None

    def read(self, index: int) -> RgbdFrame:
        """See `FrameFolder.read`."""
        file = self._depth[index]
        T_map_camera = None
        if self.truth is not None and self.poses:
            T_map_camera = pose_at(self.truth, file.stamp)
        depth, camera = self._depth_image(self.path / file.name, self._matrix)
        colour = self._colour_at(file.stamp, (camera.width, camera.height))
        return RgbdFrame(depth, camera, file.stamp, T_map_camera, colour)

    def _colour_at(self, stamp: float, size: tuple[int, int]) -> NDArray[np.uint8] | None:
        if len(self._colour) == 0:
            return None
        nearest = int(np.argmin(np.abs(self._colour_stamps - stamp)))
        if abs(self._colour_stamps[nearest] - stamp) > MAX_STAMP_DIFFERENCE_S:
            return None
        return read_colour(self.path / self._colour[nearest].name, size)

    def _truth(self) -> Trajectory | None:
        file = self.path / POSE_LIST
        return read_tum(file).moved(self.T_map_world) if file.exists() else None

    def _layout_matrix(self) -> NDArray[np.float64]:
        calibration = self.path / CALIBRATION_FILE
        if calibration.exists():
            fx, fy, cx, cy = read_numbers(calibration, 4)
            matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
            return require_matrix(matrix, calibration)
        found = re.search(r"(?:freiburg|fr)_?([123])(?![0-9])", self.path.resolve().name)
        if found is None:
            _log.warning(
                "%s: the name contains no camera (freiburg1, 2 or 3), and there is no %s or %s; "
                "using fx = fy = 525, cx = 319.5, cy = 239.5",
                self.path,
                INTRINSICS_FILE,
                CALIBRATION_FILE,
            )
        fx, fy, cx, cy = (
            _DEFAULT_INTRINSICS if found is None else _FREIBURG_INTRINSICS[found.group(1)]
        )
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def read_list(path: Path) -> list[StampedFile]:
    """Read a list of images: lines `stamp file`; # starts a comment.

    Returns:
        The images in the order of their stamps.

    Raises:
        InputError: The file cannot be read, has an invalid line, or lists no images.
    """
    try:
        require_regular(path)
        with path.open("rb") as stream:
            lines = stream.read(MAX_LIST_BYTES).decode("utf-8").splitlines()
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not text; lines 'stamp file' are expected") from error
    files: list[StampedFile] = []
    for number, line in enumerate(lines, start=1):
        words = line.split("#", 1)[0].split(maxsplit=1)
        if words:
            files.append(_entry(words, f"{path}: line {number}"))
    if not files:
        raise InputError(f"{path}: lists no images")
    return sorted(files, key=lambda file: file.stamp)


def _entry(words: list[str], place: str) -> StampedFile:
    try:
        stamp = float(words[0])
    except ValueError:
        stamp = np.nan
    if len(words) != 2 or not np.isfinite(stamp) or not words[1].strip().isprintable():
        raise InputError(f"{place}: is not 'stamp file' but {' '.join(words)[:80]!r}")
    name = words[1].strip()
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise InputError(f"{place}: {name[:80]!r} is outside the folder")
    return StampedFile(stamp, name)


def pose_at(trajectory: Trajectory, stamp: float) -> RigidTransform:
    """Interpolated pose at a time; the nearest pose if its neighbours are far apart.

    Raises:
        InputError: The nearest pose is more than `MAX_STAMP_DIFFERENCE_S` away.
    """
    stamps = trajectory.stamps
    after = int(np.searchsorted(stamps, stamp))
    around = [index for index in (after - 1, after) if 0 <= index < len(stamps)]
    nearest = min(around, key=lambda index: abs(stamps[index] - stamp), default=None)
    if nearest is None or abs(stamps[nearest] - stamp) > MAX_STAMP_DIFFERENCE_S:
        raise InputError(
            f"no true pose within {MAX_STAMP_DIFFERENCE_S * 1e3:.0f} ms of {stamp:.4f} s in "
            f"{POSE_LIST}"
        )
    gap = stamps[around[-1]] - stamps[around[0]]
    if not 0 < gap <= MAX_INTERPOLATION_GAP_S:
        return trajectory.T_map_camera[nearest]
    fraction = (stamp - stamps[around[0]]) / gap
    pair = trajectory.T_map_camera[around]
    place = (1 - fraction) * pair.translation[0] + fraction * pair.translation[1]
    return RigidTransform.from_components(place, Slerp([0.0, 1.0], pair.rotation)(fraction))
