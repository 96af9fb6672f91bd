"""Calibration of the intrinsics from images of a ChArUco board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.localization.charuco_board import (
    DICTIONARY,
    MAX_MARKERS,
    CharucoBoard,
    coverage,
    opencv_board,
)
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.opencv import opencv

MIN_VIEWS, MIN_VIEW_CORNERS = 6, 8
MAX_RMS_PX = 1.5
"""Maximum reprojection error of a valid calibration [px]."""
OUTLIER_RATIO = 3.0
"""Views whose error exceeds this multiple of the median are removed once."""
MAX_IMAGES = 3
"""Number of images that are examined."""
MIN_MARKERS, MIN_CORNERS = 4, 8
"""Minimum numbers in an image that shows a board."""
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
"""Larger or smaller OpenCV dictionaries of the same kind start with the same markers."""


@dataclass(frozen=True)
class _Markers:
    """Detected markers.

    Attributes:
        dictionary: Their dictionary.
        mirrored: Whether they are only found in the mirrored image.
    """

    dictionary: str
    mirrored: bool


def board_diagnosis(images: Sequence[NDArray[np.uint8]], board: CharucoBoard) -> str:
    """Describe how the board in the images differs from the specified one.

    Args:
        images: Grey images of one camera.
        board: The specified board.

    Returns:
        A clause with the remedy; "" if the boards agree or no board is found.

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
            return _differences(
                found, legacy, f"--columns {columns} --rows {rows}" if swapped else ""
            )
    size = f"a board of {board.columns} x {board.rows} squares does not fit; count its squares"
    return f"{_differences(found, False, '')}; {size}".removeprefix("; ")


def _differences(found: _Markers, legacy: bool, size: str) -> str:
    """Description of the differences, with remedies."""
    ours = "print the right board with: circumspect locate board"
    texts: list[str] = []
    if found.dictionary != DICTIONARY:
        texts.append(f"its markers are of {found.dictionary}, not of {DICTIONARY}; {ours}")
    if legacy:
        texts.append(f"it has the legacy pattern of OpenCV before 4.6; {ours}")
    if size:
        texts.append(f"its columns and rows are swapped; give {size}")
    if found.mirrored:
        texts.append("the images are mirrored; switch that off in the camera or its driver")
    return "; ".join(texts)


def _markers(images: Sequence[NDArray[np.uint8]]) -> _Markers | None:
    """The dictionary with the most markers, if half of the images show enough of them."""
    mirror = [np.ascontiguousarray(np.fliplr(image)) for image in images]
    # Search the long list only if the board is not from this program.
    for names in ((DICTIONARY,), DICTIONARIES[1:]):
        for mirrored, shown in ((False, images), (True, mirror)):
            counts = {name: _count(shown, name) for name in names}
            best = max(counts, key=lambda name: counts[name])
            if counts[best] >= MIN_MARKERS * len(images) / 2:
                return _Markers(best, mirrored)
    return None


def _count(images: Sequence[NDArray[np.uint8]], name: str) -> int:
    """Number of markers of a dictionary in all images."""
    aruco = opencv().aruco
    if not hasattr(aruco, name):
        return 0
    whole = aruco.getPredefinedDictionary(getattr(aruco, name))
    # No board has more markers, and detection time grows with their number.
    first = aruco.Dictionary(
        whole.bytesList[:MAX_MARKERS], whole.markerSize, whole.maxCorrectionBits
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


@dataclass(frozen=True, eq=False)
class LensCalibration:
    """Calibrated intrinsics and their accuracy.

    Attributes:
        lens: Intrinsics.
        rms_px: Root mean square reprojection error [px].
        sigmas: (9,) standard deviations of fx, fy, cx, cy [px], k1, k2, p1, p2, k3.
        views: Number of images used.
        left_out: Number of each rejected image, with the reason.
        coverage: Fraction of the image covered by corners.
    """

    lens: LensCamera
    rms_px: float
    sigmas: NDArray[np.float64]
    views: int
    left_out: dict[int, str]
    coverage: float


def calibrate_lens(images: Sequence[NDArray[np.uint8]], board: CharucoBoard) -> LensCalibration:
    """Estimate focal lengths, principal point and five distortion coefficients.

    Args:
        images: Grey images of one camera, with the board near and far, tilted, and in every corner.
        board: The board.

    Raises:
        InputError: There are too few usable images, their sizes differ, or no lens fits.
        MissingExtraError: OpenCV is not installed.
    """
    sizes = {image.shape for image in images}
    if len(sizes) > 1:
        texts = ", ".join(sorted(f"{w}x{h}" for h, w in sizes))
        raise InputError(f"the images have different sizes: {texts}; are they from one camera?")
    left_out: dict[int, str] = {}
    views: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
    for number, image in enumerate(images):
        places, pixels = board.find(image)
        if len(pixels) < MIN_VIEW_CORNERS or _on_a_line(places):
            left_out[number] = f"{len(pixels)} corners of the board; {MIN_VIEW_CORNERS} are needed"
        else:
            views[number] = (places, pixels)
    if len(views) < MIN_VIEWS and (diagnosis := board_diagnosis(images, board)):
        raise InputError(f"{_too_few(len(views), len(images))}; {diagnosis}")
    _require(len(views), len(images))
    (height, width) = next(iter(sizes))
    fit = _fitted(list(views.values()), (width, height))
    wild = fit.view_rms > OUTLIER_RATIO * max(float(np.median(fit.view_rms)), 0.05)
    if wild.any():
        for number, rms in zip([*views], fit.view_rms, strict=True):
            if rms > OUTLIER_RATIO * max(float(np.median(fit.view_rms)), 0.05):
                left_out[number] = f"its corners fit badly: {rms:.2f} px"
                del views[number]
        _require(len(views), len(images))
        fit = _fitted(list(views.values()), (width, height))
    if not fit.rms < MAX_RMS_PX:
        raise InputError(
            f"no lens fits the corners better than {fit.rms:.2f} px; check that the board is flat "
            "and has the columns, rows and square size that were given"
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
            "take more images with the board tilted"
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
    if views < MIN_VIEWS:
        raise InputError(
            f"{_too_few(views, images)}; take at least {MIN_VIEWS}, near and far, tilted, and "
            "in every corner of the image"
        )


def _too_few(views: int, images: int) -> str:
    return f"{views} of {images} images show enough of the board"
