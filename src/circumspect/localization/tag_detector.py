"""Finds tags in grey images, by pupil-apriltags."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Lock
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, MissingExtraError

FAMILY = "tag36h11"
DECIMATIONS = (1.0, 1.5, 2.0, 3.0, 4.0)
"""The library cuts other fractions down to whole numbers and then finds nothing."""
HALF_PIXEL = 0.5
"""The library counts from the top left corner of the top left pixel, we from its centre."""


@dataclass(frozen=True, eq=False)
class TagDetection:
    """One tag in an image.

    Attributes:
        tag_id: Of the family 36h11.
        corners_uv: (4, 2) [px] of the black square: lower left, lower right, upper right and
            upper left of the print.
        margin: How clearly its bits differ from the threshold, in grey levels.
        corrected_bits: So many bits were wrong.
    """

    tag_id: int
    corners_uv: NDArray[np.float64]
    margin: float
    corrected_bits: int

    @property
    def side_px(self) -> float:
        """Mean side of the black square [px]."""
        sides = self.corners_uv - np.roll(self.corners_uv, 1, axis=0)
        return float(np.linalg.norm(sides, axis=1).mean())

    @property
    def centre_uv(self) -> NDArray[np.float64]:
        """(2,) [px] where the diagonals cross: the image of the tag's centre, lens aside."""
        a, b, c, d = self.corners_uv
        along, across = c - a, d - b
        share = np.linalg.solve(np.column_stack([along, -across]), b - a)[0]
        return a + share * along


class TagDetector:
    """One detector of the library; calls from several threads wait for each other."""

    def __init__(self, decimate: float = 2.0, threads: int = 1) -> None:
        """Set up.

        Args:
            decimate: Quads are looked for in an image so many times smaller; their edges are
                then fitted in the whole one. 1 finds the smallest tags, 2 is three times as quick.
            threads: Of one detection.

        Raises:
            InputError: A value makes no sense.
            MissingExtraError: pupil-apriltags is not installed.
        """
        if decimate not in DECIMATIONS:
            known = ", ".join(f"{factor:g}" for factor in DECIMATIONS)
            raise InputError(f"images are made {known} times smaller, not {decimate:g} times")
        try:
            from pupil_apriltags import Detector
        except ImportError as error:
            raise MissingExtraError("pupil-apriltags", "locate") from error
        # The library keeps its image and its threads in the detector: one call at a time.
        self._detector = Detector(FAMILY, nthreads=threads, quad_decimate=decimate)
        self._lock = Lock()
        finalize(self, _release, self._detector)

    def detect(self, grey: NDArray[np.uint8]) -> tuple[TagDetection, ...]:
        """All tags in an image.

        Args:
            grey: (height, width) grey levels.

        Raises:
            InputError: It is no grey image of 8 bits.
        """
        if grey.ndim != 2 or grey.dtype != np.uint8:
            raise InputError(
                f"tags are looked for in grey images of 8 bits, (height, width) uint8, not in "
                f"{grey.shape} {grey.dtype}"
            )
        with self._lock:
            # Annotated as one detection, but a list of them.
            found: Any = self._detector.detect(np.ascontiguousarray(grey))
        return tuple(
            TagDetection(
                int(tag.tag_id),
                np.array(tag.corners, dtype=np.float64) - HALF_PIXEL,
                float(tag.decision_margin),
                int(tag.hamming),
            )
            for tag in found
        )


def _release(detector: Any) -> None:
    """Free a detector of the library, the families last.

    Left to itself the library frees the families first, which the detector then reads: now and
    then that ends the process.
    """
    pointer, detector.tag_detector_ptr = detector.tag_detector_ptr, None
    detector.libc.apriltag_detector_destroy.restype = None
    detector.libc.apriltag_detector_destroy(pointer)
    detector.libc.tag36h11_destroy.restype = None
    for family in detector.tag_families.values():
        detector.libc.tag36h11_destroy(family)
