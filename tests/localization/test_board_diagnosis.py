"""Diagnosis of boards that differ from the named one, from images of each."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.localization import CharucoBoard, calibrate_lens
from circumspect.localization.charuco_board import opencv_board
from circumspect.localization.lens_calibration import board_diagnosis

cv2 = pytest.importorskip("cv2")
NAMED = CharucoBoard(9, 6, 0.03)
SWAPPED = CharucoBoard(6, 9, 0.03)


def views(picture: np.ndarray, count: int = 3) -> list[np.ndarray]:
    """A board from several sides."""
    height, width = picture.shape
    corners = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
    found = []
    for number in range(count):
        rng = np.random.default_rng(number)
        pixels = (corners - corners.mean(axis=0)) * 0.85 * min(480 / width, 360 / height)
        pixels = pixels + np.array([240, 180]) + rng.uniform(-12, 12, (4, 2))
        H = cv2.getPerspectiveTransform(corners, pixels.astype(np.float32))
        found.append(cv2.warpPerspective(picture, H, (480, 360), borderValue=180))
    return found


def picture(board: CharucoBoard = NAMED, dictionary: str = "DICT_5X5_100", legacy: bool = False):
    size = (40 * board.columns, 40 * board.rows)
    made = opencv_board(board, dictionary, legacy)
    return made.generateImage(size, marginSize=0, borderBits=1)


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        (
            picture(legacy=True),
            "it has the legacy pattern of OpenCV before 4.6; print the right board",
        ),
        (picture(dictionary="DICT_6X6_250"), "its markers are of DICT_6X6_100, not of DICT_5X5"),
        (picture(dictionary="DICT_4X4_50"), "its markers are of DICT_4X4_100, not of DICT_5X5"),
        (picture(SWAPPED), "its columns and rows are swapped; give --columns 6 --rows 9"),
        (np.fliplr(picture()), "the images are mirrored; switch that off in the camera"),
        (picture(CharucoBoard(8, 6, 0.03)), "a board of 9 x 6 squares does not fit; count its"),
    ],
)
def test_a_board_that_does_not_match_is_diagnosed(shown: np.ndarray, words: str) -> None:
    with pytest.raises(InputError) as error:
        calibrate_lens(views(np.ascontiguousarray(shown)), NAMED)
    assert str(error.value).startswith(f"0 of 3 images show enough of the board; {words}")
    assert "\n" not in str(error.value)


def test_several_differences_are_all_named() -> None:
    shown = views(np.fliplr(picture(SWAPPED, "DICT_6X6_250", legacy=False)))
    found = board_diagnosis([np.ascontiguousarray(image) for image in shown], NAMED)
    assert "DICT_6X6_100" in found
    assert "--columns 6 --rows 9" in found
    assert "mirrored" in found


def test_the_named_board_and_no_board_are_no_difference() -> None:
    assert board_diagnosis(views(picture()), NAMED) == ""
    noise = np.random.default_rng(0).integers(0, 256, (240, 320)).astype(np.uint8)
    assert board_diagnosis([noise, np.full((240, 320), 128, np.uint8)], NAMED) == ""
