"""Which board the images show, where the one that was named is not found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from circumspect.localization.charuco_board import (
    DICTIONARY,
    MOST_MARKERS,
    CharucoBoard,
    opencv_board,
)
from circumspect.localization.opencv import opencv

MAX_IMAGES = 3
"""So many of the images are looked at."""
MIN_MARKERS, MIN_CORNERS = 4, 8
"""In an image, to take it for one of a board."""
DICTIONARIES = (
    DICTIONARY,
    "DICT_4X4_100",
    "DICT_6X6_100",
    "DICT_7X7_100",
    "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_36h11",
    "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_25h9",
    "DICT_ARUCO_MIP_36h12",
)
"""Those of OpenCV with fewer or more markers begin with the same ones."""


@dataclass(frozen=True)
class _Seen:
    """What an image shows.

    Attributes:
        dictionary: Of its markers.
        mirrored: Whether they are found in the mirror image only.
    """

    dictionary: str
    mirrored: bool


def diagnosed_board(images: Sequence[NDArray[np.uint8]], board: CharucoBoard) -> str:
    """Say how the board in the images differs from the one that was named.

    Args:
        images: Grey, of one camera.
        board: The one that was named.

    Returns:
        A clause with the remedy; "" where the board is the named one, or none is found.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    chosen = [images[k] for k in np.linspace(0, len(images) - 1, MAX_IMAGES).astype(int)]
    found = _markers(chosen)
    if found is None:
        return ""
    turned = [
        np.ascontiguousarray(np.fliplr(image)) if found.mirrored else image for image in chosen
    ]
    sizes = dict.fromkeys([(board.columns, board.rows), (board.rows, board.columns)])
    for legacy, (columns, rows) in product((False, True), sizes):
        if _fits(turned, CharucoBoard(columns, rows, board.square), found.dictionary, legacy):
            swapped = (columns, rows) != (board.columns, board.rows)
            return _told(found, legacy, f"--columns {columns} --rows {rows}" if swapped else "")
    size = f"a board of {board.columns} x {board.rows} squares does not fit; count its squares"
    return f"{_told(found, False, '')}; {size}".removeprefix("; ")


def _told(found: _Seen, legacy: bool, size: str) -> str:
    """The differences, each with its remedy."""
    ours = "print ours with: circumspect locate board"
    told: list[str] = []
    if found.dictionary != DICTIONARY:
        told.append(f"its markers are of {found.dictionary}, not of {DICTIONARY}; {ours}")
    if legacy:
        told.append(f"it has the legacy pattern of OpenCV before 4.6; {ours}")
    if size:
        told.append(f"its columns and rows are swapped; give {size}")
    if found.mirrored:
        told.append("the images are mirrored; switch that off in the camera or its driver")
    return "; ".join(told)


def _markers(images: Sequence[NDArray[np.uint8]]) -> _Seen | None:
    """The dictionary with most markers, of those with enough in half of the images."""
    mirror = [np.ascontiguousarray(np.fliplr(image)) for image in images]
    # Most boards are ours: the long search is for those that are not.
    for names in ((DICTIONARY,), DICTIONARIES[1:]):
        for mirrored, shown in ((False, images), (True, mirror)):
            counts = {name: _count(shown, name) for name in names}
            best = max(counts, key=lambda name: counts[name])
            if counts[best] >= MIN_MARKERS * len(images) / 2:
                return _Seen(best, mirrored)
    return None


def _count(images: Sequence[NDArray[np.uint8]], name: str) -> int:
    """Markers of a dictionary in all images."""
    aruco = opencv().aruco
    if not hasattr(aruco, name):
        return 0
    whole = aruco.getPredefinedDictionary(getattr(aruco, name))
    # No board has more markers, and the time grows with their number.
    first = aruco.Dictionary(
        whole.bytesList[:MOST_MARKERS], whole.markerSize, whole.maxCorrectionBits
    )
    detector = aruco.ArucoDetector(first)
    found = (detector.detectMarkers(image)[1] for image in images)
    return sum(len(numbers) for numbers in found if numbers is not None)


def _fits(
    images: Sequence[NDArray[np.uint8]], board: CharucoBoard, dictionary: str, legacy: bool
) -> bool:
    """Whether half of the images show enough corners of a board."""
    detector = opencv().aruco.CharucoDetector(opencv_board(board, dictionary, legacy))
    shown = 0
    for image in images:
        _, numbers, _, _ = detector.detectBoard(image)
        shown += numbers is not None and len(numbers) >= MIN_CORNERS
    return shown >= len(images) / 2
