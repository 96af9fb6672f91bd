"""Dressers and night stands: carcasses of drawers on legs, plinths or the floor."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.drawers import drawer_fronts
from circumspect.furniture.legs import four_legs
from circumspect.furniture.placement import both_sides, joined, moved
from circumspect.furniture.primitives import box
from circumspect.geometry import TriangleMesh


def dresser(rng: np.random.Generator) -> TriangleMesh:
    """A chest of drawers, front to -y, 0.6 to 1.8 m wide."""
    tall = rng.random() < 0.55
    columns = int(rng.integers(1, 3)) if tall else int(rng.integers(2, 4))
    rows = int(rng.integers(4, 7)) if tall else int(rng.integers(3, 5))
    width = rng.uniform(0.7, 1.1) if tall else rng.uniform(1.1, 1.75)
    height = rng.uniform(1.0, 1.45) if tall else rng.uniform(0.7, 0.95)
    depth = rng.uniform(0.4, 0.56)
    lift, stand = _stand(rng, width, depth, rng.uniform(0.03, 0.16))
    parts = [stand] if stand is not None else []
    parts.append(moved(_chest(rng, (width, depth, height - lift), (columns, rows)), (0, 0, lift)))
    if not tall and rng.random() < 0.12:
        parts.append(_mirror(rng, width, depth, height))
    return joined(parts)


def night_stand(rng: np.random.Generator) -> TriangleMesh:
    """A small stand with drawers or an open shelf, front to -y, 0.45 to 0.75 m high."""
    width = rng.uniform(0.38, 0.65)
    depth = width * rng.uniform(0.7, 0.95)
    height = rng.uniform(0.45, 0.75)
    kind = str(rng.choice(["drawers", "open", "leggy"], p=[0.45, 0.3, 0.25]))
    if kind == "leggy":
        return _leggy_stand(rng, width, depth, height)
    lift, stand = _stand(rng, width, depth, rng.uniform(0.03, 0.2))
    parts = [stand] if stand is not None else []
    size = (width, depth, height - lift)
    if kind == "drawers":
        body = _chest(rng, size, (1, int(rng.integers(1, 4))))
    else:
        body = _open_chest(rng, size)
    return joined([*parts, moved(body, (0.0, 0.0, lift))])


def _stand(
    rng: np.random.Generator, width: float, depth: float, lift: float
) -> tuple[float, TriangleMesh | None]:
    """What a chest stands on, and how high: legs, a plinth, or nothing."""
    kind = str(rng.choice(["legs", "plinth", "none"], p=[0.55, 0.25, 0.2]))
    if kind == "none":
        return 0.0, None
    if kind == "plinth":
        shy = rng.uniform(0.9, 1.0)
        return lift, box((width * shy, depth * shy, lift), (0.0, 0.0, 0.0))
    thick = rng.uniform(0.035, 0.06)
    return lift, four_legs(rng, (width - 1.3 * thick, depth - 1.3 * thick), lift, thick)


def _chest(
    rng: np.random.Generator, size: tuple[float, float, float], grid: tuple[int, int]
) -> TriangleMesh:
    """A carcass with a top that juts out and fronts of drawers."""
    width, depth, height = size
    top = rng.uniform(0.015, 0.04)
    jut = rng.choice([0.0, rng.uniform(0.005, 0.03)])
    body = box((width, depth, height - top))
    lid = box((width + 2 * jut, depth + 2 * jut, top), (0.0, 0.0, height - top))
    return joined([body, lid, drawer_fronts(rng, (width, height - top), -depth / 2, grid)])


def _open_chest(rng: np.random.Generator, size: tuple[float, float, float]) -> TriangleMesh:
    """One drawer above, or below, an open shelf."""
    width, depth, height = size
    board = rng.uniform(0.015, 0.03)
    box_high = height * rng.uniform(0.3, 0.5)
    above = rng.random() < 0.8
    base = height - box_high if above else 0.0
    parts = [
        both_sides(box((board, depth, height), ((width - board) / 2, 0.0, 0.0))),
        box((width, depth, board)),
        box((width, depth, board), (0.0, 0.0, height - board)),
        moved(_chest(rng, (width - board, depth, box_high), (1, 1)), (0.0, 0.0, base)),
    ]
    if rng.random() < 0.6:
        parts.append(box((width, board, height), (0.0, (depth - board) / 2, 0.0)))
    return joined(parts)


def _leggy_stand(
    rng: np.random.Generator, width: float, depth: float, height: float
) -> TriangleMesh:
    """A drawer on four long legs, perhaps with a shelf between them."""
    thick = rng.uniform(0.03, 0.05)
    box_high = height * rng.uniform(0.2, 0.4)
    lift = height - box_high
    parts = [
        four_legs(rng, (width - 1.2 * thick, depth - 1.2 * thick), lift, thick),
        moved(_chest(rng, (width, depth, box_high), (1, 1)), (0.0, 0.0, lift)),
    ]
    if rng.random() < 0.5:
        level = lift * rng.uniform(0.2, 0.5)
        parts.append(box((width - thick, depth - thick, 0.018), (0.0, 0.0, level)))
    return joined(parts)


def _mirror(rng: np.random.Generator, width: float, depth: float, height: float) -> TriangleMesh:
    """An upright mirror in a frame behind the top."""
    wide = width * rng.uniform(0.5, 0.9)
    tall = rng.uniform(0.5, 0.9)
    return box((wide, 0.04, tall), (0.0, depth / 2 - 0.02, height))
