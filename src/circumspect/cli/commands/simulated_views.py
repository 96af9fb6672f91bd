"""Images of simulated ceiling cameras on disk, for the other subcommands of `locate`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.cli.commands.simulated_space import SimulatedSpace
from circumspect.errors import InputError
from circumspect.localization import CeilingImage, CharucoBoard, write_calibration, write_survey
from circumspect.simulation import board_images
from circumspect.storage import atomic_path

BOARD_VIEWS = 12
NAMES = ("board", "floor", "survey.json", "track", "calibration.json")


class SimulatedViews:
    """Writes images in the layout that `ImageFolder` and the calibrations read.

    | name | contents |
    |---|---|
    | board/CAMERA | the board held up to each camera |
    | floor/CAMERA | the surveyed tags |
    | survey.json | their poses by a tape measure |
    | track/CAMERA | the driving robot; the file name is the stamp [s] |
    | calibration.json | the calibrated cameras, and the robot's tag |
    """

    def __init__(self, folder: Path) -> None:
        """Check the folder; nothing is written yet.

        Args:
            folder: Made if missing.

        Raises:
            InputError: It contains images of another simulation, which would be mixed with these,
                or a survey or calibration, which would be replaced.
        """
        held = [name for name in NAMES if os.path.lexists(folder / name)]
        if held:
            raise InputError(f"{folder}: holds {held[0]} already; give an empty or a new folder")
        self.folder = folder

    def calibration(self, space: SimulatedSpace) -> None:
        """Write images of board and floor, survey and calibration.

        Raises:
            OutputError: A file can not be written.
        """
        write_survey(self.folder / "survey.json", space.survey)
        write_calibration(self.folder / "calibration.json", space.calibration)
        board = CharucoBoard()
        for camera in space.rig.cameras:
            name = camera.camera.name
            held = board_images(camera, board, BOARD_VIEWS, space.setup.seed)
            for number, grey in enumerate(held):
                _write(self.folder / "board" / name / f"{number:02}.png", grey)
            floor = camera.photograph(0.0, space.laid).grey
            _write(self.folder / "floor" / name / "00.png", floor)

    def save(self, images: Sequence[CeilingImage]) -> None:
        """Write the images of one time.

        Raises:
            OutputError: A file can not be written.
        """
        for image in images:
            _write(self.folder / "track" / image.camera / f"{image.stamp:.3f}.png", image.grey)


def _write(path: Path, grey: NDArray[np.uint8]) -> None:
    from PIL import Image

    with atomic_path(path) as aside:
        Image.fromarray(grey).save(aside, compress_level=1)
