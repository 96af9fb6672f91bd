"""Intrinsics from images of a ChArUco board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.localization.board_diagnosis import diagnosed_board
from circumspect.localization.charuco_board import CharucoBoard, coverage
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.opencv import opencv

FEWEST_VIEWS, FEWEST_CORNERS = 6, 8
LARGEST_RMS = 1.5
"""Of a calibration that can be meant [px]."""
OUTLYING = 3.0
"""A view whose error is so many times the median's is left out once."""


@dataclass(frozen=True, eq=False)
class LensCalibration:
    """A lens and how well it is known.

    Attributes:
        lens: Intrinsics.
        rms_px: Of the reprojection error [px].
        sigmas: (9,) standard deviations of fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        views: How many images took part.
        left_out: Numbers of the images that did not, with the reason.
        coverage: Share of the image in which corners were.
    """

    lens: LensCamera
    rms_px: float
    sigmas: NDArray[np.float64]
    views: int
    left_out: dict[int, str]
    coverage: float


def calibrate_lens(images: Sequence[NDArray[np.uint8]], board: CharucoBoard) -> LensCalibration:
    """Fit focal lengths, principal point and five coefficients of distortion.

    Args:
        images: Grey, of one camera; the board near and far, tilted, and in every corner.
        board: What they show.

    Raises:
        InputError: Too few usable images, of different sizes, or nothing fits them.
        MissingExtraError: OpenCV is not installed.
    """
    sizes = {image.shape for image in images}
    if len(sizes) > 1:
        told = ", ".join(sorted(f"{w}x{h}" for h, w in sizes))
        raise InputError(f"the images have different sizes: {told}; they are of one camera?")
    left_out: dict[int, str] = {}
    views: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
    for number, image in enumerate(images):
        places, pixels = board.find(image)
        if len(pixels) < FEWEST_CORNERS or _on_a_line(places):
            left_out[number] = f"{len(pixels)} corners of the board, {FEWEST_CORNERS} are needed"
        else:
            views[number] = (places, pixels)
    if len(views) < FEWEST_VIEWS and (fault := diagnosed_board(images, board)):
        raise InputError(f"{_too_few(len(views), len(images))}; {fault}")
    _require(len(views), len(images))
    (height, width) = next(iter(sizes))
    fit = _fitted(list(views.values()), (width, height))
    wild = fit.view_rms > OUTLYING * max(float(np.median(fit.view_rms)), 0.05)
    if wild.any():
        for number, rms in zip([*views], fit.view_rms, strict=True):
            if rms > OUTLYING * max(float(np.median(fit.view_rms)), 0.05):
                left_out[number] = f"its corners fit badly: {rms:.2f} px"
                del views[number]
        _require(len(views), len(images))
        fit = _fitted(list(views.values()), (width, height))
    if not fit.rms < LARGEST_RMS:
        raise InputError(
            f"no lens fits the corners better than {fit.rms:.2f} px; see that the board is flat "
            "and has the columns, rows and squares that were given"
        )
    shown = coverage([pixels for _, pixels in views.values()], (width, height))
    return LensCalibration(fit.lens, fit.rms, fit.sigmas, len(views), left_out, shown)


@dataclass(frozen=True, eq=False)
class _Fit:
    lens: LensCamera
    rms: float
    sigmas: NDArray[np.float64]
    view_rms: NDArray[np.float64]


def _fitted(
    views: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]], size: tuple[int, int]
) -> _Fit:
    cv2 = opencv()
    places = [places.astype(np.float32).reshape(-1, 1, 3) for places, _ in views]
    pixels = [pixels.astype(np.float32).reshape(-1, 1, 2) for _, pixels in views]
    try:
        rms, K, bend, _, _, sigmas, _, view_rms = cv2.calibrateCameraExtended(
            places, pixels, size, None, None
        )
    except cv2.error as error:
        raise InputError(
            f"the lens can not be calibrated from these images ({str(error).split(chr(10))[0]}); "
            "take more, with the board tilted"
        ) from error
    values = [float(value) for value in np.ravel(bend)[:5]]
    values += [0.0] * (5 - len(values))
    k1, k2, p1, p2, k3 = values
    pinhole = PinholeCamera(*size, float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]))
    lens = LensCamera(pinhole, (k1, k2, p1, p2, k3))
    return _Fit(lens, float(rms), np.ravel(sigmas)[:9].astype(np.float64), np.ravel(view_rms))


def _on_a_line(places_xyz: NDArray[np.float64]) -> bool:
    return len(places_xyz) < 3 or np.linalg.matrix_rank(places_xyz - places_xyz[0], tol=1e-6) < 2


def _require(views: int, images: int) -> None:
    if views < FEWEST_VIEWS:
        raise InputError(
            f"{_too_few(views, images)}; take at least {FEWEST_VIEWS}, near and far, tilted, and "
            "in every corner of the image"
        )


def _too_few(views: int, images: int) -> str:
    return f"{views} of {images} images show enough of the board"
