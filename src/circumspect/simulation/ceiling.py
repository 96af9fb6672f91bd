"""Placement of ceiling cameras that together cover the whole floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.localization import FixedCamera, LensCamera

OVERLAP_M = 0.45
"""Overlap of neighbouring views on each side [m]."""
MAX_WIDTH_RATIO = 2.4
"""Maximum ratio of the width of a view to its distance."""
CORNER_DISTORTION = (-0.13, 0.02, 0.0, 0.0, -0.001)
"""Relative displacement of the image corners by k1, k2 and k3."""
TILT_RAD = float(np.radians(3.0))
"""Typical tilt of the cameras [rad]."""
MAX_HEIGHT_M = 100.0
"""Maximum height of a hall [m]."""


def ceiling_cameras(
    low_xy: ArrayLike,
    high_xy: ArrayLike,
    count: int = 4,
    height: float = 3.0,
    plane: float = 0.30,
    size: tuple[int, int] = (1280, 960),
    seed: int = 0,
) -> tuple[FixedCamera, ...]:
    """Create cameras over a rectangle, each above the centre of its part.

    Each lens has its own distortion, like those of cheap cameras with such a field of view.

    Args:
        low_xy: (2,) corner with the smallest coordinates [m].
        high_xy: (2,) opposite corner [m].
        count: Number of cameras.
        height: Height of the ceiling [m].
        plane: Height that the views must cover, that of the tag [m].
        size: Width and height of the images [px].
        seed: Seed of all random numbers.

    Raises:
        InputError: There is no camera or no area, the area is too large for the cameras, or the
            ceiling is too low or too high.
    """
    low, high = np.asarray(low_xy, float), np.asarray(high_xy, float)
    if not 0 <= plane < height <= MAX_HEIGHT_M:
        raise InputError(
            f"the ceiling must be above {plane:g} m and at most {MAX_HEIGHT_M:g} m high, not "
            f"{height:g} m"
        )
    if count < 1 or not (high > low).all():
        raise InputError(f"{count} cameras at {height} m can not see from {low} to {high}")
    sides = high - low
    columns, rows = _cells(count, float(sides[0] / sides[1]))
    cell = sides / [columns, rows]
    reach = cell + 2 * OVERLAP_M
    turned = bool(reach[1] > reach[0])
    wide, narrow = (reach[1], reach[0]) if turned else (reach[0], reach[1])
    distance = height - plane
    focal = float(min(size[0] * distance / wide, size[1] * distance / narrow))
    if size[0] / focal > MAX_WIDTH_RATIO:
        raise InputError(
            f"{count} cameras at {height} m can not see {sides[0]:.1f} x {sides[1]:.1f} m; "
            "use more cameras"
        )
    rng = np.random.default_rng(seed)
    cameras = []
    for number in range(count):
        place = low + cell * np.array([number % columns + 0.5, number // columns + 0.5])
        heading = (np.pi / 2 if turned else 0.0) + rng.normal(0, np.radians(4))
        down = Rotation.from_euler("z", heading) * Rotation.from_euler("x", np.pi)
        rotation = down * Rotation.from_euler("xy", rng.normal(0, TILT_RAD, 2))
        position = [*place, height + float(rng.normal(0, 0.01))]
        pose = RigidTransform.from_components(position, rotation)
        cameras.append(FixedCamera(f"ceiling_{number}", _lens(size, focal, rng), pose))
    return tuple(cameras)


def _cells(count: int, aspect: float) -> tuple[int, int]:
    """Numbers of columns and rows with few empty cells and cells that are nearly square."""
    grids = [(columns, -(-count // columns)) for columns in range(1, count + 1)]
    return min(grids, key=lambda g: (g[0] * g[1] - count, abs(np.log(aspect * g[1] / g[0]))))


def _lens(size: tuple[int, int], focal: float, rng: np.random.Generator) -> LensCamera:
    w, h = size
    fx = focal * float(rng.normal(1, 0.005))
    centre = np.array([w - 1, h - 1]) / 2 + rng.normal(0, 0.006 * w, 2)
    pinhole = PinholeCamera(w, h, fx, fx * float(rng.normal(1, 0.001)), *map(float, centre))
    corner = float(np.hypot(w, h)) / 2 / focal
    radial = np.array(CORNER_DISTORTION) / corner ** np.array([2, 4, 0, 0, 6])
    bend = radial * rng.normal(1, 0.05, 5)
    bend[2:4] = rng.normal(0, 4e-4, 2)
    k1, k2, p1, p2, k3 = bend.tolist()
    return LensCamera(pinhole, (k1, k2, p1, p2, k3))
