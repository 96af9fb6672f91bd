"""Recordings by what they are."""

from __future__ import annotations

import os
from pathlib import Path

from circumspect.errors import InputError
from circumspect.recording.bag import Bag
from circumspect.recording.bag_recording import BagRecording, BagSettings
from circumspect.recording.mcap_bag import McapBag
from circumspect.recording.recording import Recording
from circumspect.recording.ros_bag import RosBag
from circumspect.recording.seven_scenes import DEPTH_NAME, SevenScenesFolder
from circumspect.recording.tum_rgbd import DEPTH_LIST, TumRgbdFolder

BAG_INDEX = "metadata.yaml"
MCAP_SUFFIX = ".mcap"
BAG_SUFFIXES = (MCAP_SUFFIX, ".db3", ".bag")


def open_recording(
    path: str | os.PathLike[str],
    every: int = 1,
    poses: bool = True,
    settings: BagSettings | None = None,
) -> Recording:
    """Open a recording, whichever kind it is.

    Args:
        path: An MCAP file, a bag of ROS 2 (folder or db3 file) or ROS 1, or a folder of 7-Scenes
            (frame-*.depth.png) or of TUM RGB-D (depth.txt).
        every: Take each n-th frame only.
        poses: Whether frames bring the recorded poses along.
        settings: How a bag is to be understood.

    Raises:
        InputError: No such file or folder, one of no known layout, or something in it is broken.
        MissingExtraError: It is a bag, and what reads bags is not installed.
    """
    if is_bag(path):
        return BagRecording(open_bag(path), every, poses, settings)
    folder = Path(path)
    if not folder.is_dir():
        raise InputError(
            f"{folder}: no such recording; give a bag ({', '.join(BAG_SUFFIXES)}) or a folder of "
            "7-Scenes or TUM RGB-D"
        )
    if (folder / DEPTH_LIST).exists():
        return TumRgbdFolder(folder, every, poses)
    if any(DEPTH_NAME.fullmatch(file.name) for file in folder.iterdir()):
        return SevenScenesFolder(folder, every, poses)
    raise InputError(
        f"{folder}: holds neither {BAG_INDEX} (a bag), nor frame-*.depth.png (7-Scenes), nor "
        f"{DEPTH_LIST} (TUM RGB-D)"
    )


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Whether a path names a bag, by its suffix or by the index in its folder."""
    place = Path(path)
    if place.is_dir():
        return (place / BAG_INDEX).exists() or _only_mcap(place) is not None
    return place.suffix.lower() in BAG_SUFFIXES


def open_bag(path: str | os.PathLike[str]) -> Bag:
    """Open a bag.

    Raises:
        InputError: It can not be read.
        MissingExtraError: What reads bags is not installed.
    """
    place = Path(path)
    if place.is_dir():
        only = _only_mcap(place)
        return RosBag(place) if only is None else McapBag(only)
    if place.suffix.lower() == MCAP_SUFFIX:
        return McapBag(place)
    return RosBag(place)


def _only_mcap(folder: Path) -> Path | None:
    """The MCAP file of a folder with just one; it may lack the index of a bag that was killed."""
    files = [file for file in folder.iterdir() if file.suffix.lower() == MCAP_SUFFIX]
    return files[0] if len(files) == 1 else None
