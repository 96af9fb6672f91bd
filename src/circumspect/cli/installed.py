"""Which packages circumspect asks for, by extra, and which of them are there."""

from __future__ import annotations

import re
from importlib import metadata

RUNTIME = "runtime"
FOR = {
    RUNTIME: "classify, grid, replay of folders",
    "figures": "pictures and figures",
    "sim": "demo, scan, gather: the simulated robot",
    "train": "train, export, reproduce, nets",
    "data": "data fetch",
    "formats": "files of LAS, LAZ, E57, and GLB with Draco",
    "usd": "files of USD and USDZ",
    "bags": "--record, replay of bags",
    "locate": "locate: ceiling cameras",
    "viewer": "view, --viewer: the dashboard",
    "ros2": "ros2: the node",
    "realsense": "watch: RealSense cameras",
    "cluster": "--cluster: jobs on Ray",
    "docs": "make docs",
}
"""What an extra is for."""
NOT_SHOWN = ("all", "test")
ENTRY = re.compile(r"([\w.-]+)(?:\[([\w,-]+)\])?[^;]*(?:;.*extra == [\"']([\w-]+)[\"'])?")


def installed() -> dict[str, dict[str, str | None]]:
    """Extra to package to its version, None where it is missing; what the package itself says."""
    found: dict[str, dict[str, str | None]] = {RUNTIME: {}}
    for extra in metadata.metadata("circumspect").get_all("Provides-Extra") or ():
        if extra not in NOT_SHOWN:
            found[extra] = {}
    for entry in metadata.requires("circumspect") or ():
        match = ENTRY.match(entry)
        if match is not None and match[1] != "circumspect" and (match[3] or RUNTIME) in found:
            found[match[3] or RUNTIME][match[1]] = version(match[1])
    return found


def version(package: str) -> str | None:
    """Of a package that is installed, else None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def remedy(extra: str) -> str:
    """What to type to get it."""
    return "pip install circumspect" if extra == RUNTIME else f'pip install "circumspect[{extra}]"'
