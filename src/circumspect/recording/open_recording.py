"""Recordings by what their folders hold."""

from __future__ import annotations

import os
from pathlib import Path

from circumspect.errors import InputError
from circumspect.recording.frame_folder import FrameFolder, GivenPoses
from circumspect.recording.seven_scenes import DEPTH_NAME, SevenScenesFolder
from circumspect.recording.tum_rgbd import DEPTH_LIST, TumRgbdFolder


def open_recording(
    path: str | os.PathLike[str], every: int = 1, poses: GivenPoses = GivenPoses.ALL
) -> FrameFolder:
    """Open a folder of RGB-D frames, whichever layout it has.

    Args:
        path: A folder of 7-Scenes (frame-*.depth.png) or of TUM RGB-D (depth.txt).
        every: Take each n-th frame only.
        poses: Which of the recorded poses frames bring along.

    Raises:
        InputError: No such folder, one of neither layout, or something in it is broken.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give one of 7-Scenes or TUM RGB-D")
    if (folder / DEPTH_LIST).exists():
        return TumRgbdFolder(folder, every, poses)
    if any(DEPTH_NAME.fullmatch(file.name) for file in folder.iterdir()):
        return SevenScenesFolder(folder, every, poses)
    raise InputError(
        f"{folder}: holds neither frame-*.depth.png (7-Scenes) nor {DEPTH_LIST} (TUM RGB-D)"
    )
