"""Detection of tags in grey images with pupil-apriltags."""

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
"""Supported decimations; the library rounds others down and then finds nothing."""
HALF_PIXEL = 0.5
"""Offset of the library's origin, the corner of the first pixel instead of its centre."""


@dataclass(frozen=True, eq=False)
class TagDetection:
    """A detected tag.

    Attributes:
        tag_id: Number in the family 36h11.
        corners_uv: (4, 2) [px] of the black square: lower left, lower right, upper right and
            upper left of the print.
        margin: Mean distance of the bits from the threshold, in grey levels.
        corrected_bits: Number of corrected bits.
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
        """(2,) intersection of the diagonals [px]: the tag's centre, up to lens distortion."""
        a, b, c, d = self.corners_uv
        along, across = c - a, d - b
        share = np.linalg.solve(np.column_stack([along, -across]), b - a)[0]
        return a + share * along


class TagDetector:
    """A detector of the library; calls from several threads are serialised."""

    def __init__(self, decimate: float = 2.0, threads: int = 1) -> None:
        """Create a detector.

        Args:
            decimate: Quads are searched in an image smaller by this factor; their edges are
                then fitted in the full one. 1 finds the smallest tags, 2 is three times as fast.
            threads: Number of threads of a detection.

        Raises:
            InputError: A value is invalid.
            MissingExtraError: pupil-apriltags is not installed.
        """
        if decimate not in DECIMATIONS:
            known = ", ".join(f"{factor:g}" for factor in DECIMATIONS)
            raise InputError(f"decimate must be one of {known}, not {decimate:g}")
        try:
            from pupil_apriltags import Detector
        except ImportError as error:
            raise MissingExtraError("pupil-apriltags", "locate") from error
        # The detector holds the image and threads of a call: one call at a time.
        self._detector = Detector(FAMILY, nthreads=threads, quad_decimate=decimate)
        self._lock = Lock()
        finalize(self, _release, self._detector)

    def detect(self, grey: NDArray[np.uint8]) -> tuple[TagDetection, ...]:
        """All tags in an image.

        Args:
            grey: (height, width) grey levels.

        Raises:
            InputError: It is not a grey image of 8 bits.
        """
        if grey.ndim != 2 or grey.dtype != np.uint8:
            raise InputError(
                f"tags are looked for in grey images of 8 bits, (height, width) uint8, not in "
                f"{grey.shape} {grey.dtype}"
            )
        with self._lock:
            # Annotated as one detection, but in fact a list.
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
    """Free a detector of the library, and its families last.

    By default the library frees the families first, but the detector then reads them, which
    sometimes crashes the process.
    """
    pointer, detector.tag_detector_ptr = detector.tag_detector_ptr, None
    detector.libc.apriltag_detector_destroy.restype = None
    detector.libc.apriltag_detector_destroy(pointer)
    detector.libc.tag36h11_destroy.restype = None
    for family in detector.tag_families.values():
        detector.libc.tag36h11_destroy(family)
