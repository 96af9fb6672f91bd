"""Objects on a patch of floor, as a phone or a depth camera scans them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.furniture import make_furniture


def on_floor(
    category: str,
    variant: int = 3,
    beyond: float = 1.6,
    share: float = 0.5,
    noise: float = 0.0,
    lean: float = 0.0,
    wall: bool = False,
    strays: int = 0,
    points: int = 12_000,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """An object on a disc of floor.

    Args:
        category: Of the furniture.
        variant: Of the furniture.
        beyond: The disc reaches so many times as far out as the object.
        share: Of the points of both that lie on the floor.
        noise: Standard deviation of all coordinates [m].
        lean: Tilt of the whole scan about x [rad].
        wall: A wall stands at the border of the floor.
        strays: Points anywhere.
        points: On the object.

    Returns:
        (n, 3) points [m], and (n,) which of them are the object's.
    """
    rng = np.random.default_rng(variant)
    object_xyz = make_furniture(category, variant).sampled(points, 0).points_xyz
    count = int(share * points / (1 - share))
    reach = beyond * float(np.hypot(*object_xyz[:, :2].T).max())
    angle, away = rng.uniform(0, 2 * np.pi, count), reach * np.sqrt(rng.uniform(0, 1, count))
    ground = float(object_xyz[:, 2].min())
    disc = np.column_stack([away * np.cos(angle), away * np.sin(angle), np.full(count, ground)])
    parts = [object_xyz, disc]
    if wall:
        sizes = np.column_stack([np.full(points // 2, reach), *rng.random((2, points // 2))])
        parts.append(sizes * [1, 2 * reach, 1.2] - [0, reach, -ground])
    if strays:
        parts.append(rng.uniform(-3 * reach, 3 * reach, (strays, 3)))
    whole = np.concatenate(parts)
    whole = whole + rng.normal(0, noise, whole.shape)
    is_object = np.arange(len(whole)) < points
    return Rotation.from_rotvec([lean, 0, 0]).apply(whole), is_object
