"""Pinhole camera with lens distortion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PinholeCamera

NEWTON_STEPS = 25
MIN_STEP = 1e-12
"""Step on the plane at depth 1 m below which the iteration ends."""
MAX_EXTRAPOLATION = 1.15
"""The lens model is valid up to this multiple of the distance of the image corners."""
COEFFICIENT_COUNTS = (4, 5, 8, 12, 14)
"""Possible numbers of coefficients in OpenCV's model: k1, k2, p1, p2, then k3, then unsupported
ones: k4 to k6 (rational), s1 to s4 (thin prism), tx, ty (tilted sensor)."""
MODELS = ("", "plumb_bob", "radtan", "pinhole", "brown_conrady", "rational_polynomial")
"""Names of the supported lens model; "" if a file names none."""
INTEGER_TOLERANCE = 1e-9
REMEDY = "calibrate with: circumspect locate intrinsics"


@dataclass(frozen=True)
class LensCamera:
    """Brown-Conrady lens model with OpenCV's five coefficients.

    With (x, y) a point on the plane at depth 1 m and r² = x² + y², the lens moves it to
    (x, y)(1 + k1 r² + k2 r⁴ + k3 r⁶) + (2 p1 xy + p2 (r² + 2x²), p1 (r² + 2y²) + 2 p2 xy).

    Attributes:
        pinhole: Image size, focal lengths and principal point.
        distortion: k1, k2, p1, p2, k3.

    Raises:
        GeometryError: Coefficients that are not five finite numbers, or that fold the image.
    """

    pinhole: PinholeCamera
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        values = np.asarray(self.distortion, dtype=np.float64)
        if values.shape != (5,) or not np.isfinite(values).all():
            raise GeometryError(f"distortion is k1, k2, p1, p2, k3, not {self.distortion}")
        object.__setattr__(self, "distortion", tuple(values.tolist()))
        if not np.isfinite(self.reach):
            raise GeometryError(
                f"the distortion {self.distortion} folds the image; calibrate the camera again"
            )

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.pinhole.width, self.pinhole.height

    @cached_property
    def reach(self) -> float:
        """Maximum distance of the image from the axis at depth 1 m; NaN if it folds."""
        w, h = self.pinhole.width, self.pinhole.height
        along = np.linspace(-0.5, 1, 13)[1:-1]
        edges = [(s * w, e) for s in along for e in (-0.5, h - 0.5)]
        edges += [(e, s * h) for s in along for e in (-0.5, w - 0.5)]
        corners = [(u, v) for u in (-0.5, w - 0.5) for v in (-0.5, h - 0.5)]
        inside = [(u, v) for u, v in edges if -0.5 <= u <= w - 0.5 and -0.5 <= v <= h - 0.5]
        return float(np.linalg.norm(self.rays_xy(np.array(corners + inside)), axis=1).max())

    def project(self, points_xyz: ArrayLike) -> NDArray[np.float64]:
        """Project points into the image.

        Args:
            points_xyz: (n, 3) [m] in the optical frame.

        Returns:
            (n, 2) [px], not limited to the image; NaN for points behind the camera, or outside
            the validity of the lens model.
        """
        x, y, z = np.asarray(points_xyz, dtype=np.float64).T
        depth = np.where(z > 0, z, np.nan)
        xy = np.stack([x / depth, y / depth], axis=1)
        xy[np.linalg.norm(xy, axis=1) > MAX_EXTRAPOLATION * self.reach] = np.nan
        return self._pixels(self._distorted(xy)[0])

    def projection_slopes(self, points_xyz: ArrayLike) -> NDArray[np.float64]:
        """Derivatives of `project`.

        Args:
            points_xyz: (n, 3) [m] in the optical frame, in front of the camera.

        Returns:
            (n, 2, 3) [px/m].
        """
        x, y, z = np.asarray(points_xyz, dtype=np.float64).T
        xy = np.stack([x / z, y / z], axis=1)
        flat = np.zeros((len(xy), 2, 3))
        flat[:, 0, 0] = flat[:, 1, 1] = 1 / z
        flat[:, :, 2] = -xy / z[:, None]
        focal = np.array([self.pinhole.fx, self.pinhole.fy])
        return focal[:, None] * (self._distorted(xy)[1] @ flat)

    def rays_xy(self, pixels_uv: ArrayLike) -> NDArray[np.float64]:
        """Undistorted rays of pixels, by Newton's method.

        Args:
            pixels_uv: (n, 2) [px].

        Returns:
            (n, 2) the point at depth 1 m along each pixel's ray, optical frame; NaN where the
            lens model has no such ray.
        """
        camera = self.pinhole
        wanted = (np.asarray(pixels_uv, dtype=np.float64) - [camera.cx, camera.cy]) / [
            camera.fx,
            camera.fy,
        ]
        xy = wanted.copy()
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                bent, slopes = self._distorted(xy)
                step = _solved(slopes, wanted - bent)
                xy = xy + step
                if not np.nanmax(np.abs(step), initial=0.0) > MIN_STEP:
                    break
            bent, slopes = self._distorted(xy)
            upright = slopes[:, 0, 0] * slopes[:, 1, 1] > slopes[:, 0, 1] * slopes[:, 1, 0]
            found = upright & (np.abs(bent - wanted).max(axis=1) < 1e-9)
        return np.where(found[:, None], xy, np.nan)

    def _pixels(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        camera = self.pinhole
        return xy * [camera.fx, camera.fy] + [camera.cx, camera.cy]

    def _distorted(
        self, xy: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distorted points (n, 2), and their derivatives (n, 2, 2)."""
        k1, k2, p1, p2, k3 = self.distortion
        x, y = xy.T
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        growth = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))  # d radial / d r², twice
        bent = np.stack(
            [
                x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
            ],
            axis=1,
        )
        slopes = np.empty((len(xy), 2, 2))
        slopes[:, 0, 0] = radial + x * x * growth + 2 * p1 * y + 6 * p2 * x
        slopes[:, 1, 1] = radial + y * y * growth + 6 * p1 * y + 2 * p2 * x
        slopes[:, 0, 1] = slopes[:, 1, 0] = x * y * growth + 2 * p1 * x + 2 * p2 * y
        return bent, slopes


def _solved(slopes: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve many 2 x 2 systems of equations."""
    a, b, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 1]
    determinant = a * d - b * b
    u, v = right.T
    return np.stack([(d * u - b * v) / determinant, (a * v - b * u) / determinant], axis=1)


def lens_of(
    size: Sequence[float], K: Sequence[float], distortion: Sequence[float], model: str = ""
) -> LensCamera:
    """Create a lens from calibration values.

    Args:
        size: Width and height [px].
        K: Nine numbers of the camera matrix, row by row [px].
        distortion: 4, 5, 8, 12 or 14 coefficients in OpenCV's order.
        model: Name of the model in the file.

    Raises:
        InputError: Unsupported model or coefficients, a matrix with skew, or
            image sides that are not integers.
        GeometryError: The values are impossible.
    """
    if model.lower() not in MODELS:
        raise InputError(
            f"the lens model {model[:40]!r} is not supported (fisheye lenses are not); known are "
            f"{', '.join(name for name in MODELS if name)}; {REMEDY}"
        )
    fx, skew, cx, zero, fy, cy, *last = K
    if skew or zero or last != [0, 0, 1]:
        raise InputError(
            "K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew, not "
            f"{list(K)}; {REMEDY}"
        )
    width, height = size
    if abs(width - round(width)) + abs(height - round(height)) > INTEGER_TOLERANCE:
        raise InputError(f"an image has whole pixels, not {width} x {height}")
    pinhole = PinholeCamera(round(width), round(height), fx, fy, cx, cy)
    return LensCamera(pinhole, _five(distortion))


def _five(distortion: Sequence[float]) -> tuple[float, float, float, float, float]:
    values = np.ravel(np.asarray(distortion, np.float64)).tolist()
    if len(values) not in COEFFICIENT_COUNTS:
        raise InputError(
            f"distortion has 4, 5, 8, 12 or 14 coefficients (k1, k2, p1, p2, k3, …), not "
            f"{len(values)}"
        )
    if any(values[5:]):
        raise InputError(
            "distortion beyond k1, k2, p1, p2, k3 (rational, thin prism, tilted) is not supported; "
            f"{REMEDY}, or with five coefficients in the other program"
        )
    k1, k2, p1, p2, k3 = [*values, 0.0][:5]
    return k1, k2, p1, p2, k3
