"""Recordings by what they are."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from circumspect.errors import InputError
from circumspect.recording.bag import Bag
from circumspect.recording.bag_recording import BagRecording, BagSettings
from circumspect.recording.mcap_bag import McapBag
from circumspect.recording.numbered_folder import (
    DEPTH_FOLDER,
    SCANNET_INTRINSICS,
    SCANNET_POSES,
    Open3dFolder,
    ScanNetFolder,
)
from circumspect.recording.recording import Recording
from circumspect.recording.ros_bag import RosBag
from circumspect.recording.seven_scenes import DEPTH_NAME, SevenScenesFolder
from circumspect.recording.tum_rgbd import DEPTH_LIST, TumRgbdFolder
from circumspect.recording.unread_kinds import unread_kind
from circumspect.sensing.regular_file import require_regular

BAG_INDEX = "metadata.yaml"
MCAP_SUFFIX = ".mcap"
BAG_SUFFIXES = (MCAP_SUFFIX, ".db3", ".bag")


def open_recording(
    path: str | os.PathLike[str],
    every: int = 1,
    poses: bool = True,
    settings: BagSettings | None = None,
    depth_scale: float | None = None,
) -> Recording:
    """Open a recording, whichever kind it is.

    Args:
        path: An MCAP file, a bag of ROS 2 (folder or db3 file) or ROS 1, or a folder of 7-Scenes
            (frame-*.depth.png), of TUM RGB-D or ETH3D (depth.txt), of ScanNet or Open3D (depth/).
        every: Take each n-th frame only.
        poses: Whether frames bring the recorded poses along.
        settings: How a bag is to be understood.
        depth_scale: Metres a unit of the depth images; None for that of the layout or encoding.

    Raises:
        InputError: No such file or folder, one of no known layout, or something in it is broken.
        MissingExtraError: It is a bag, and what reads bags is not installed.
    """
    if is_bag(path):
        if depth_scale is not None:
            settings = replace(settings or BagSettings(), depth_scale=depth_scale)
        return BagRecording(open_bag(path), every, poses, settings)
    folder = Path(path)
    if not folder.is_dir():
        require_known_kind(folder)
        raise InputError(
            f"{folder}: no such recording; give a bag ({', '.join(BAG_SUFFIXES)}) or a folder of "
            "7-Scenes or TUM RGB-D"
        )
    if (folder / DEPTH_LIST).exists():
        return TumRgbdFolder(folder, every, poses, depth_scale)
    if any(DEPTH_NAME.fullmatch(file.name) for file in folder.iterdir()):
        return SevenScenesFolder(folder, every, poses, depth_scale)
    if (folder / DEPTH_FOLDER).is_dir():
        is_scannet = (folder / SCANNET_INTRINSICS).exists() or (folder / SCANNET_POSES).is_dir()
        kind = ScanNetFolder if is_scannet else Open3dFolder
        return kind(folder, every, poses, depth_scale)
    raise InputError(
        f"{folder}: holds neither {BAG_INDEX} (a bag), nor frame-*.depth.png (7-Scenes), nor "
        f"{DEPTH_LIST} (TUM RGB-D, ETH3D), nor {DEPTH_FOLDER}/ (ScanNet, Open3D)"
    )


def require_known_kind(path: str | os.PathLike[str]) -> None:
    """Check that a file is none of those that look like recordings and are not read as they are.

    Raises:
        InputError: It is one; the message says what to do.
    """
    if (remedy := unread_kind(Path(path))) is not None:
        raise InputError(f"{path}: {remedy}")


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Whether a path names a bag, by its suffix or by the index in its folder."""
    place = Path(path)
    if place.is_dir():
        return (place / BAG_INDEX).exists() or bool(_bag_files(place))
    return place.suffix.lower() in BAG_SUFFIXES


def open_bag(path: str | os.PathLike[str]) -> Bag:
    """Open a bag.

    Raises:
        InputError: It can not be read.
        MissingExtraError: What reads bags is not installed.
    """
    place = Path(path)
    if place.is_dir():
        return _open_folder(place)
    if place.suffix.lower() == MCAP_SUFFIX:
        return McapBag(place)
    return RosBag(place)


def _open_folder(folder: Path) -> Bag:
    """A bag in a folder; one of a recorder that was killed may lack the index."""
    files = _bag_files(folder)
    if len(files) == 1 and files[0].suffix.lower() == MCAP_SUFFIX:
        return McapBag(files[0])
    if (folder / BAG_INDEX).exists():
        return RosBag(folder)
    if len(files) == 1:
        require_known_kind(files[0])
        return RosBag(files[0])
    try:
        for file in files:
            require_regular(file)
    except OSError as error:
        raise InputError(f"{folder}: can not be read ({error})") from error
    kinds = {file.suffix.lower() for file in files}
    storage = "mcap" if kinds == {MCAP_SUFFIX} else "sqlite3"
    raise InputError(
        f"{folder}: holds {len(files)} files of a bag but no {BAG_INDEX}; write it with: "
        f"ros2 bag reindex -s {storage} {folder}, or give one of the files"
    )


def _bag_files(folder: Path) -> list[Path]:
    """Files of a bag, whole or packed, in a folder."""
    return sorted(
        file
        for file in folder.iterdir()
        if any(word in (".mcap", ".db3") for word in map(str.lower, file.suffixes[-2:]))
        and (file.suffix.lower() in BAG_SUFFIXES or unread_kind(file) is not None)
    )
