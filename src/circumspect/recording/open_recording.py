"""Opening of recordings by their format."""

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
from circumspect.sensing.untrusted_files import require_regular

BAG_INDEX = "metadata.yaml"
MCAP_SUFFIX = ".mcap"
BAG_SUFFIXES = (MCAP_SUFFIX, ".db3", ".bag")
REMEDIES = {
    ".bag.active": (
        "is a ROS 1 bag that was not closed; repair it with: rosbag reindex {path}, and rename it "
        "to end in .bag"
    ),
    ".bag.gz": "is a compressed bag; decompress it with: gunzip {path}",
    ".mcap.zst": "is a compressed MCAP file; decompress it with: zstd -d {path}",
    ".mcap.zstd": "is a compressed MCAP file; decompress it with: zstd -d {path} -o NEW.mcap",
    ".mcap.gz": "is a compressed MCAP file; decompress it with: gunzip {path}",
    ".mcap.lz4": "is a compressed MCAP file; decompress it with: lz4 -d {path}",
    ".db3.zst": "is a compressed file of a bag; decompress it with: zstd -d {path}",
    ".db3.zstd": (
        "is a compressed file of a bag; give the bag's folder with its metadata.yaml, or "
        "decompress it with: zstd -d {path} -o NEW.db3"
    ),
    ".sens": "is a ScanNet file; export it with ScanNet's SensReader, and give the folder",
    ".klg": "is a recording of ElasticFusion's logger; convert it to a folder or a bag",
    ".oni": "is a recording of OpenNI; play it with openni2_camera and record a bag",
}
"""End of a file name to a description of the file and the remedy."""


def open_recording(
    path: str | os.PathLike[str],
    every: int = 1,
    poses: bool = True,
    settings: BagSettings | None = None,
    depth_scale: float | None = None,
) -> Recording:
    """Open a recording of any supported format.

    Args:
        path: An MCAP file, a bag of ROS 2 (folder or db3 file) or ROS 1, or a folder of 7-Scenes
            (frame-*.depth.png), TUM RGB-D or ETH3D (depth.txt), ScanNet or Open3D (depth/).
        every: Use every n-th frame only.
        poses: Whether frames carry the recorded poses.
        settings: How to interpret a bag.
        depth_scale: Metres per unit of the depth images; None for the default of the format.

    Raises:
        InputError: The path does not exist, has an unknown layout, or is broken.
        MissingExtraError: The libraries that read bags are not installed.
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
        f"{folder}: contains none of {BAG_INDEX} (a bag), frame-*.depth.png (7-Scenes), "
        f"{DEPTH_LIST} (TUM RGB-D, ETH3D) and {DEPTH_FOLDER}/ (ScanNet, Open3D)"
    )


def require_known_kind(path: str | os.PathLike[str]) -> None:
    """Refuse files of formats that must be converted or decompressed first.

    Raises:
        InputError: The file has such a format; the message names the remedy.
    """
    if (remedy := unread_kind(Path(path))) is not None:
        raise InputError(f"{path}: {remedy}")


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Whether a path is a bag, by its suffix or by the index in its folder."""
    place = Path(path)
    if place.is_dir():
        return (place / BAG_INDEX).exists() or bool(_bag_files(place))
    return place.suffix.lower() in BAG_SUFFIXES


def open_bag(path: str | os.PathLike[str]) -> Bag:
    """Open a bag.

    Raises:
        InputError: The bag cannot be read.
        MissingExtraError: The libraries that read bags are not installed.
    """
    place = Path(path)
    if place.is_dir():
        return _open_folder(place)
    if place.suffix.lower() == MCAP_SUFFIX:
        return McapBag(place)
    return RosBag(place)


def _open_folder(folder: Path) -> Bag:
    """Open the bag in a folder; after a killed recorder the index may be missing."""
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
        f"{folder}: contains {len(files)} files of a bag but no {BAG_INDEX}; create it with: "
        f"ros2 bag reindex -s {storage} {folder}, or give one of the files"
    )


def _bag_files(folder: Path) -> list[Path]:
    """Files of a bag in a folder, compressed ones included."""
    return sorted(
        file
        for file in folder.iterdir()
        if any(word in (".mcap", ".db3") for word in map(str.lower, file.suffixes[-2:]))
        and (file.suffix.lower() in BAG_SUFFIXES or unread_kind(file) is not None)
    )


def unread_kind(path: Path) -> str | None:
    """Description of an unsupported file with the remedy; None for other files."""
    name = path.name.lower()
    ends = (end for end in REMEDIES if name.endswith(end))
    end = next(ends, None)
    return None if end is None else REMEDIES[end].format(path=path)
