"""Corruptions of clouds in five severities.

Jitter, dropping, adding and scaling follow ModelNet-C (Ren, Pan and Liu, "Benchmarking and
Analyzing Point Cloud Classification under Corruptions", ICML 2022). The others are errors of a
robot: occlusion, an incomplete orbit, a leaning or displaced axis, misregistered views, remaining
floor. ModelNet40-C (Sun et al. 2022) has other kinds of occlusion and rotation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.errors import InputError
from circumspect.geometry import PointCloud

Points = NDArray[np.float64]
Areas = NDArray[np.float64]
Corruption = Callable[[Points, int, np.random.Generator], Points | tuple[Points, Areas]]
SEVERITIES = (1, 2, 3, 4, 5)
CLUSTER_SPREAD = (0.075, 0.125)
"""Standard deviation of a cluster of added points [object radii]."""


def corrupted(cloud: PointCloud, kind: str, severity: int, rng: np.random.Generator) -> PointCloud:
    """Corrupt a cloud.

    Args:
        cloud: (n, 3) points, z up.
        kind: One of `CORRUPTIONS`.
        severity: 1 to 5.
        rng: Random generator.

    Returns:
        A new cloud; "shift" changes the areas, so that the weighted centre moves.

    Raises:
        InputError: The corruption or severity does not exist.
    """
    if kind not in CORRUPTIONS:
        raise InputError(f"no corruption {kind!r}; known: {', '.join(CORRUPTIONS)}")
    if severity not in SEVERITIES:
        raise InputError(f"severities are 1 to 5, not {severity}")
    centre = cloud.points_xyz.mean(axis=0)
    radius = float(np.linalg.norm(cloud.points_xyz - centre, axis=1).max()) or 1.0
    points = (cloud.points_xyz - centre) / radius
    changed, areas = CORRUPTIONS[kind](points, severity, rng), None
    if isinstance(changed, tuple):
        changed, areas = changed
    return PointCloud(changed * radius + centre, areas=areas)


def _jitter(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Add noise of 0.01 … 0.05 to every coordinate."""
    return points + rng.normal(0, 0.01 * severity, points.shape)


def _drop_global(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Remove a quarter … three quarters of the points."""
    kept = round(len(points) * (1 - (0.125 + 0.125 * severity)))
    return points[rng.permutation(len(points))[: max(kept, 3)]]


def _drop_local(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Remove a tenth … half of the points, in up to seven holes."""
    for size in _cluster_sizes(len(points), severity, rng):
        away = np.linalg.norm(points - points[rng.integers(len(points))], axis=1)
        points = points[np.argsort(away)[size:]]
    return points


def _add_global(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Add 1 % … 5 % stray points in the ball around the object."""
    count = round(0.01 * severity * len(points))
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([points, directions * np.cbrt(rng.random((count, 1)))])


def _add_local(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Add a tenth … half as many points in up to seven clusters on the surface."""
    added = []
    for size in _cluster_sizes(len(points), severity, rng):
        spread = rng.uniform(*CLUSTER_SPREAD)
        added.append(points[rng.integers(len(points))] + rng.normal(0, spread, (size, 3)))
    extra = np.concatenate(added)
    return np.concatenate([points, extra / np.maximum(np.linalg.norm(extra, axis=1), 1)[:, None]])


def _scale(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Stretch or shrink each axis by up to 1.6 … 2.0."""
    most = 1.5 + 0.1 * severity
    return points * rng.uniform(1 / most, most, 3)


def _occlusion(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Occlude a tenth … half of the object."""
    angle = rng.uniform(0, 2 * np.pi)
    along = points[:, :2] @ [np.cos(angle), np.sin(angle)]
    return points[along <= np.quantile(along, 1 - 0.1 * severity)]


def _arc(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Remove a sector of 30° … 180° about the axis."""
    missing = np.deg2rad(30 + 37.5 * (severity - 1))
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    kept = (azimuth - rng.uniform(0, 2 * np.pi)) % (2 * np.pi) >= missing
    return points[kept] if np.count_nonzero(kept) > 3 else points


def _tilt(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Tilt the axis by 2° … 10°."""
    angle = rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(angle), np.sin(angle), 0.0])
    return Rotation.from_rotvec(axis * np.deg2rad(2.0 * severity)).apply(points)


def _registration(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Rotate each of four views by about 1° … 5° and shift it by about 0.01 … 0.05."""
    azimuth = np.arctan2(points[:, 1], points[:, 0]) + rng.uniform(0, 2 * np.pi)
    views = np.floor((azimuth % (2 * np.pi)) / (np.pi / 2)).astype(int)
    moved = points.copy()
    for view in range(4):
        turn = Rotation.from_rotvec(rng.normal(0, np.deg2rad(1.0 * severity), 3) * [0.3, 0.3, 1.0])
        shift = rng.normal(0, 0.01 * severity, 3)
        moved[views == view] = turn.apply(points[views == view]) + shift
    return moved


def _floor(points: Points, severity: int, rng: np.random.Generator) -> Points:
    """Add a disc of floor that extends 4 % … 20 % beyond the object."""
    reach = np.hypot(points[:, 0], points[:, 1]).max() * (1 + 0.04 * severity)
    count = round(len(points) * 0.06 * severity)
    angle, away = rng.uniform(0, 2 * np.pi, count), reach * np.sqrt(rng.random(count))
    low = np.full(count, points[:, 2].min())
    return np.concatenate(
        [points, np.column_stack([away * np.cos(angle), away * np.sin(angle), low])]
    )


def _shift(points: Points, severity: int, rng: np.random.Generator) -> tuple[Points, Areas]:
    """Set areas that shift the weighted centre by about 0.03 … 0.15."""
    angle = rng.uniform(0, 2 * np.pi)
    wanted = 0.03 * severity * np.array([np.cos(angle), np.sin(angle)])
    about = points[:, :2] - points[:, :2].mean(axis=0)
    spread = about.T @ about / len(about) + 1e-6 * np.eye(2)
    return points, np.maximum(1 + about @ np.linalg.solve(spread, wanted), 0.0)


def _cluster_sizes(count: int, severity: int, rng: np.random.Generator) -> list[int]:
    """Up to seven sizes that sum to a tenth … half of all points."""
    clusters = int(rng.integers(1, 8))
    shares = rng.multinomial(round(0.1 * severity * count), np.full(clusters, 1 / clusters))
    return [int(share) for share in shares]


CORRUPTIONS: Mapping[str, Corruption] = MappingProxyType(
    {
        "jitter": _jitter,
        "drop-global": _drop_global,
        "drop-local": _drop_local,
        "add-global": _add_global,
        "add-local": _add_local,
        "scale": _scale,
        "occlusion": _occlusion,
        "arc": _arc,
        "tilt": _tilt,
        "shift": _shift,
        "registration": _registration,
        "floor": _floor,
    }
)
"""All kinds by name; "shift" also returns areas. The unit of length is the largest distance from
the mean point."""
