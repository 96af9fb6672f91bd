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
from circumspect.sensing.picture import opened_picture

KINDS = (".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff")
STAMPS = "stamps.txt"
FORMATS = ("PNG", "JPEG", "PPM", "BMP", "TIFF")
"""Pillow knows more, and hands some of them to other programs."""
MOST_PIXELS = 8192
"""Along a side; a small file can hold a huge picture of one colour."""
LARGEST_LIST = 50_000_000
"""Longer lists of images are something else [bytes]."""
LATEST = 1e11
"""No clock says so much [s]: it would be in the year 5138."""


@dataclass(frozen=True)
class _Entry:
    stamp: float
    camera: str
    path: Path


class ImageFolder:
    """A folder with a sub-folder for each camera, named after it.

    An image's name is its stamp in seconds, 12.340.png, or a file stamps.txt beside the images has
    a line for each: its name and its stamp. Iterating gives the images of all cameras in the order
    of their stamps; whatever else gives an iterable of `CeilingImage` can stand in for it.

    Attributes:
        path: The folder.
        cameras: Names, sorted.
        skipped: Files that could not be read so far, with the reason.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """List the images.

        Raises:
            InputError: No folder, no camera's sub-folder, or names that are no stamps.
        """
        self.path = Path(path)
        if not self.path.is_dir():
            raise InputError(f"{self.path}: is no folder; give one with a sub-folder a camera")
        folders = sorted(folder for folder in self.path.iterdir() if folder.is_dir())
        entries = {folder.name: _entries(folder) for folder in folders}
        self.cameras = tuple(name for name, found in entries.items() if found)
        if not self.cameras:
            raise InputError(
                f"{self.path}: holds no sub-folder with images ({', '.join(KINDS)}); each camera "
                "needs one, named after it"
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
    """One image in grey.

    Raises:
        InputError: It can not be read.
    """
    with opened_picture(Path(path), FORMATS, MOST_PIXELS) as image:
        if image.mode.startswith(("I", "F")):
            raise InputError(f"{path}: has more than 8 bits; convert it to 8")
        return np.array(image.convert("L"))


def image_files(paths: list[Path]) -> list[Path]:
    """Images as they are named, and those of folders in the order of their names.

    Raises:
        InputError: Nothing is there.
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
                f"{path}: its name is no stamp in seconds; rename it, as 12.340.png, or write "
                f"names and stamps into {folder / STAMPS}"
            )
        entries.append(_Entry(_in_seconds(stamp, path), folder.name, path))
    return entries


def _in_seconds(stamp: float, path: Path) -> float:
    if abs(stamp) > LATEST:
        raise InputError(f"{path}: a stamp of {stamp:.3g} s; are these nanoseconds? Give seconds")
    return stamp


def _listed(path: Path) -> dict[str, float]:
    """Name to stamp."""
    stamps = {}
    try:
        with path.open("rb") as stream:
            lines = stream.read(LARGEST_LIST).decode("utf-8").splitlines()
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
