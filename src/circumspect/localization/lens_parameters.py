"""A lens by the numbers that calibrations of several programs hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.localization.lens_camera import LensCamera

COUNTS = (4, 5, 8, 12, 14)
"""So many coefficients OpenCV's model has: k1, k2, p1, p2, then k3, then those that are not used
here: k4 to k6 (rational), s1 to s4 (thin prism), tx, ty (tilted sensor)."""
MODELS = ("", "plumb_bob", "radtan", "pinhole", "brown_conrady", "rational_polynomial")
"""Names of the lens model in use here; "" where a file names none."""
WHOLE = 1e-9
MAKE = "calibrate with: circumspect locate intrinsics"


def lens_of(
    size: Sequence[float], K: Sequence[float], distortion: Sequence[float], model: str = ""
) -> LensCamera:
    """The lens with five coefficients.

    Args:
        size: Width and height [px].
        K: Nine numbers of the camera matrix, row by row [px].
        distortion: 4, 5, 8, 12 or 14 coefficients in OpenCV's order.
        model: What a file calls the model.

    Raises:
        InputError: Another model or coefficients that are not used here, a matrix with skew, or
            sides that are not whole.
        GeometryError: No such camera can be.
    """
    if model.lower() not in MODELS:
        raise InputError(
            f"the lens model {model[:40]!r} is not supported (fisheye lenses are not); known are "
            f"{', '.join(name for name in MODELS if name)}; {MAKE}"
        )
    fx, skew, cx, zero, fy, cy, *last = K
    if skew or zero or last != [0, 0, 1]:
        raise InputError(
            f"K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew, not {list(K)}; {MAKE}"
        )
    width, height = size
    if abs(width - round(width)) + abs(height - round(height)) > WHOLE:
        raise InputError(f"an image has whole pixels, not {width} x {height}")
    pinhole = PinholeCamera(round(width), round(height), fx, fy, cx, cy)
    return LensCamera(pinhole, _five(distortion))


def _five(distortion: Sequence[float]) -> tuple[float, float, float, float, float]:
    values = np.ravel(np.asarray(distortion, np.float64)).tolist()
    if len(values) not in COUNTS:
        raise InputError(
            f"distortion has 4, 5, 8, 12 or 14 coefficients (k1, k2, p1, p2, k3, …), not "
            f"{len(values)}"
        )
    if any(values[5:]):
        raise InputError(
            "distortion beyond k1, k2, p1, p2, k3 (rational, thin prism, tilted) is not supported; "
            f"{MAKE}, or with five coefficients in the other program"
        )
    k1, k2, p1, p2, k3 = [*values, 0.0][:5]
    return k1, k2, p1, p2, k3
