"""Images of ceiling cameras in a folder."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.localization.ceiling_image import CeilingImage
from circumspect.sensing.untrusted_files import opened_picture

KINDS = (".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff")
STAMPS = "stamps.txt"
FORMATS = ("PNG", "JPEG", "PPM", "BMP", "TIFF")
"""Pillow passes some other formats to external programs."""
MAX_SIDE_PX = 8192
"""Maximum image side [px]; a small file can contain a huge image."""
MAX_LIST_BYTES = 50_000_000
"""Maximum size of a list of images [bytes]."""
MAX_STAMP_S = 1e11
"""Maximum stamp [s]; it lies in the year 5138."""


@dataclass(frozen=True)
class _Entry:
    stamp: float
    camera: str
    path: Path


class ImageFolder:
    """A folder with a sub-folder per camera, named after it.

    The name of an image is its stamp in seconds, such as 12.340.png, or a file stamps.txt in the
    sub-folder has a line with name and stamp for each image. Iteration yields the images of all
    cameras in the order of their stamps. Any iterable of `CeilingImage` can replace this class.

    Attributes:
        path: The folder.
        cameras: Names of the cameras, sorted.
        skipped: Unreadable files so far, with the reason.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """List the images.

        Raises:
            InputError: There is no folder, no sub-folder of a camera, or a name is not a stamp.
        """
        self.path = Path(path)
        if not self.path.is_dir():
            raise InputError(f"{self.path}: is not a folder; give one with a sub-folder per camera")
        folders = sorted(folder for folder in self.path.iterdir() if folder.is_dir())
        entries = {folder.name: _entries(folder) for folder in folders}
        self.cameras = tuple(name for name, found in entries.items() if found)
        if not self.cameras:
            raise InputError(
                f"{self.path}: contains no sub-folder with images ({', '.join(KINDS)}); each "
                "camera needs one, named after it"
            )
        every = (entry for found in entries.values() for entry in found)
        self._entries = sorted(every, key=lambda entry: (entry.stamp, entry.camera))
        self.skipped: dict[str, str] = {}

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[CeilingImage]:
        for entry in self._entries:
            try:
                yield CeilingImage(entry.camera, entry.stamp, read_grey(entry.path))
            except InputError as error:
                self.skipped[str(entry.path)] = str(error).removeprefix(f"{entry.path}: ")


def read_grey(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """Read an image in grey.

    Raises:
        InputError: The image cannot be read.
    """
    with opened_picture(Path(path), FORMATS, MAX_SIDE_PX) as image:
        if image.mode.startswith(("I", "F")):
            raise InputError(f"{path}: has more than 8 bits; convert it to 8 bits")
        return np.array(image.convert("L"))


def image_files(paths: list[Path]) -> list[Path]:
    """Image files among paths, including those in folders, sorted by name.

    Raises:
        InputError: A path does not exist, or there is no image.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            found += sorted(p for p in path.iterdir() if p.suffix.lower() in KINDS)
        elif path.is_file():
            found.append(path)
        else:
            raise InputError(f"{path}: does not exist")
    if not found:
        raise InputError("no image was given; name files or folders of them")
    return found


def _entries(folder: Path) -> list[_Entry]:
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in KINDS)
    if (folder / STAMPS).is_file():
        stamps = _listed(folder / STAMPS)
        missing = [path.name for path in files if path.name not in stamps]
        if missing:
            raise InputError(f"{folder / STAMPS}: has no stamp of {missing[0]}")
        return [_Entry(stamps[path.name], folder.name, path) for path in files]
    entries = []
    for path in files:
        try:
            stamp = float(path.stem)
        except ValueError:
            stamp = math.nan
        if not math.isfinite(stamp):
            raise InputError(
                f"{path}: its name is not a stamp in seconds; rename it, such as 12.340.png, or "
                f"write names and stamps into {folder / STAMPS}"
            )
        entries.append(_Entry(_in_seconds(stamp, path), folder.name, path))
    return entries


def _in_seconds(stamp: float, path: Path) -> float:
    if abs(stamp) > MAX_STAMP_S:
        raise InputError(f"{path}: a stamp of {stamp:.3g} s; are these nanoseconds? Give seconds")
    return stamp


def _listed(path: Path) -> dict[str, float]:
    """Stamps by name."""
    stamps = {}
    try:
        with path.open("rb") as stream:
            lines = stream.read(MAX_LIST_BYTES).decode("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: can not be read ({error})") from error
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            name, stamp = words[0], float(words[1])
        except (IndexError, ValueError):
            raise InputError(f"{path}: line {number} is not: NAME SECONDS") from None
        if not math.isfinite(stamp):
            raise InputError(f"{path}: line {number} has no finite stamp")
        stamps[name] = _in_seconds(stamp, path)
    return stamps
