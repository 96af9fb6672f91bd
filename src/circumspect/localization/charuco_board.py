"""ChArUco board for the calibration of lenses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.localization.opencv import opencv

MARKER_SHARE = 0.7
"""Side of a marker relative to a square: seven modules of a tenth each."""
MAX_MARKERS = 100
DICTIONARY = "DICT_5X5_100"
"""OpenCV's name of the marker dictionary."""


@dataclass(frozen=True)
class CharucoBoard:
    """A chessboard with markers in its white squares, so that a visible part suffices.

    The default fits on a sheet of A4.

    Attributes:
        columns, rows: Number of squares.
        square: Side of a square [m].

    Raises:
        InputError: The sizes are impossible.
    """

    columns: int = 9
    rows: int = 6
    square: float = 0.03

    def __post_init__(self) -> None:
        if self.columns < 3 or self.rows < 3 or self.columns * self.rows > 2 * MAX_MARKERS:
            raise InputError(
                f"a board has 3 x 3 to {2 * MAX_MARKERS} squares, not {self.columns} x {self.rows}"
            )
        if not 0.002 <= self.square <= 1:
            raise InputError(f"squares are from 0.002 to 1 m large, not {self.square} m")

    @property
    def width(self) -> float:
        """[m]."""
        return self.columns * self.square

    @property
    def height(self) -> float:
        """[m]."""
        return self.rows * self.square

    def picture(self, pixels: int = 40) -> NDArray[np.uint8]:
        """Picture of the board without margin.

        Args:
            pixels: Side of a square; with a multiple of 20 all edges fall between pixels.

        Raises:
            MissingExtraError: OpenCV is not installed.
        """
        size = (self.columns * pixels, self.rows * pixels)
        return self._board.generateImage(size, marginSize=0, borderBits=1)

    def find(self, grey: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Inner corners of the chessboard in an image.

        Args:
            grey: (height, width) uint8.

        Returns:
            (n, 3) [m] places on the board and (n, 2) [px] in the image; n may be 0.

        Raises:
            MissingExtraError: OpenCV is not installed.
        """
        corners, numbers, _, _ = self._detector.detectBoard(np.ascontiguousarray(grey))
        if numbers is None or len(numbers) == 0:
            return np.empty((0, 3)), np.empty((0, 2))
        places = np.asarray(self._board.getChessboardCorners(), dtype=np.float64)
        pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
        return places[np.asarray(numbers).ravel()], pixels

    @cached_property
    def _board(self) -> Any:
        return opencv_board(self)

    @cached_property
    def _detector(self) -> Any:
        return opencv().aruco.CharucoDetector(self._board)


def opencv_board(board: CharucoBoard, dictionary: str = DICTIONARY, legacy: bool = False) -> Any:
    """OpenCV's `CharucoBoard`.

    Args:
        board: Squares and their side.
        dictionary: OpenCV's name of the marker dictionary.
        legacy: Whether to use the layout of OpenCV before 4.6 for even numbers of rows.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    aruco = opencv().aruco
    markers = aruco.getPredefinedDictionary(getattr(aruco, dictionary))
    size = (board.columns, board.rows)
    made = aruco.CharucoBoard(size, board.square, MARKER_SHARE * board.square, markers)
    made.setLegacyPattern(legacy)
    return made


def coverage(pixels: Sequence[NDArray[np.float64]], size: tuple[int, int]) -> float:
    """Fraction of the image, in 8 x 6 fields, in which some view has a corner.

    Args:
        pixels: (n, 2) [px] of each view.
        size: Width and height [px].
    """
    every = np.concatenate([np.empty((0, 2)), *pixels])
    fields = np.floor(every / np.array(size) * [8, 6]).astype(int)
    inside = ((fields >= 0) & (fields < [8, 6])).all(axis=1)
    return len({tuple(field) for field in fields[inside].tolist()}) / 48
