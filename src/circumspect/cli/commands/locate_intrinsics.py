"""`circumspect locate intrinsics`."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from circumspect.cli.config_file import ConfigFlag
from circumspect.errors import InputError


@dataclass(frozen=True)
class Intrinsics:
    """Calibrate the intrinsics of one camera from images of the board.

    $ circumspect locate intrinsics board-images/ceiling_0 --out calibration.json
    $ circumspect locate intrinsics a.png b.png c.png --camera north --out room.json
    """

    images: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="IMAGES")]
    """Images of the board, or a folder of images: at least six, near and far, tilted, and in every
    corner of the view."""
    out: Path
    """Calibration file to write; its entries of other cameras are kept."""
    camera: str | None = None
    """Name of the camera; by default that of the folder of the images."""
    columns: int = 9
    """Number of squares in a row of the printed board."""
    rows: int = 6
    """Number of rows of squares."""
    square: float = 0.03
    """Side of a square, measured on the print [m]."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Detect corners, fit the intrinsics and write the calibration."""
        from circumspect.localization import (
            Calibration,
            CharucoBoard,
            calibrate_lens,
            read_calibration,
            write_calibration,
        )
        from circumspect.localization.image_folder import image_files, read_grey

        board = CharucoBoard(self.columns, self.rows, self.square)
        calibration = read_calibration(self.out) if self.out.exists() else Calibration({}, {})
        files = image_files(list(self.images))
        name = self.camera or folder_camera(files)
        found = calibrate_lens([read_grey(file) for file in files], board)
        write_calibration(self.out, calibration.with_lens(name, found.lens, found.rms_px))
        pinhole = found.lens.pinhole
        record = {
            "camera": name,
            "rms_px": found.rms_px,
            "fx": pinhole.fx,
            "fy": pinhole.fy,
            "cx": pinhole.cx,
            "cy": pinhole.cy,
            "distortion": list(found.lens.distortion),
            "views": found.views,
            "coverage": found.coverage,
            "left_out": {str(files[n]): reason for n, reason in found.left_out.items()},
            "calibration": str(self.out),
        }
        if self.json:
            print(json.dumps(record))  # noqa: T201
            return 0
        for file, reason in record["left_out"].items():
            print(f"left out: {file}: {reason}")  # noqa: T201
        print(  # noqa: T201
            f"Camera '{name}': {found.rms_px:.3f} px over {found.views} images, corners in "
            f"{found.coverage:.0%} of the image; f = {pinhole.fx:.1f}, {pinhole.fy:.1f} px."
        )
        if found.coverage < 0.6:
            print("That is little: take images with the board in the other corners, too.")  # noqa: T201
        print(f"Next: circumspect locate extrinsics IMAGES --intrinsics {self.out} …")  # noqa: T201
        return 0


def folder_camera(files: Iterable[Path]) -> str:
    """The name of the camera, from the folder of its images.

    Args:
        files: The images.

    Raises:
        InputError: The images are in folders of different names.
    """
    names = sorted({file.absolute().parent.name for file in files})
    if len(names) > 1:
        raise InputError(
            f"images from {len(names)} folders, {' and '.join(names[:2])}: a camera at a time; if "
            "they are all of one, name it by --camera"
        )
    return names[0]
