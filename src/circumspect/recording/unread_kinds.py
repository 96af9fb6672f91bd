"""Files that look like recordings and are not read as they are, each with what to do."""

from __future__ import annotations

from pathlib import Path

REMEDIES = {
    ".bag.active": (
        "is a bag of ROS 1 that was not closed; mend it with: rosbag reindex {path}, and rename it "
        "to end in .bag"
    ),
    ".bag.gz": "is a packed bag; unpack it with: gunzip {path}",
    ".mcap.zst": "is an MCAP file packed as a whole; unpack it with: zstd -d {path}",
    ".mcap.zstd": "is an MCAP file packed as a whole; unpack it with: zstd -d {path} -o NEW.mcap",
    ".mcap.gz": "is a packed MCAP file; unpack it with: gunzip {path}",
    ".mcap.lz4": "is a packed MCAP file; unpack it with: lz4 -d {path}",
    ".db3.zst": "is a packed file of a bag; unpack it with: zstd -d {path}",
    ".db3.zstd": (
        "is a packed file of a bag; give the bag's folder, whose metadata.yaml says how it is "
        "packed, or unpack it with: zstd -d {path} -o NEW.db3"
    ),
    ".sens": "is a ScanNet file; export it with ScanNet's SensReader, and give the folder",
    ".klg": "is a recording of ElasticFusion's logger; convert it to a folder or a bag",
    ".oni": "is a recording of OpenNI; play it with openni2_camera and record a bag",
}
"""End of a name to what the file is, and the remedy."""


def unread_kind(path: Path) -> str | None:
    """What a file is that is not read as it is, with the remedy; None for other files."""
    name = path.name.lower()
    ends = (end for end in REMEDIES if name.endswith(end))
    end = next(ends, None)
    return None if end is None else REMEDIES[end].format(path=path)
