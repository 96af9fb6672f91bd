"""Desks: a top on drawer pedestals, panels or legs, with modesty panel, hutch or return."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.drawers import drawer_fronts
from circumspect.furniture.legs import four_legs
from circumspect.furniture.placement import joined, mirrored, moved
from circumspect.furniture.primitives import box
from circumspect.geometry import TriangleMesh

_BOARD = 0.02


def desk(rng: np.random.Generator) -> TriangleMesh:
    """A desk, its user sits at -y; 1.0 to 2.0 m wide, 0.7 to 0.78 m high without a hutch."""
    width = rng.uniform(1.0, 1.9)
    depth = float(np.clip(width * rng.uniform(0.42, 0.6), 0.5, 0.95))
    height = rng.uniform(0.7, 0.79)
    thickness = rng.uniform(0.02, 0.05)
    under = height - thickness
    left, right = [
        (True, True), (True, False), (False, True), (False, False)
    ][int(rng.choice(4, p=[0.36, 0.2, 0.2, 0.24]))]  # fmt: skip
    parts = [box((width, depth, thickness), (0.0, 0.0, under))]
    parts += _sides(rng, left, right, width, depth, under)
    if rng.random() < 0.6:
        drop = under * rng.choice([0.35, 0.6, 0.85, 1.0])
        y = depth / 2 - rng.uniform(0.02, 0.12)
        parts.append(box((width * 0.94, _BOARD, drop), (0.0, y, under - drop)))
    if rng.random() < 0.3:
        parts.append(_middle_drawer(rng, width * 0.4, depth, under))
    if rng.random() < 0.24:
        parts.append(moved(_hutch(rng, width, depth), (0.0, 0.0, height)))
    whole = joined(parts)
    if rng.random() < 0.22:
        whole = joined([whole, _return(rng, width, depth, height, thickness)])
    return mirrored(whole) if rng.random() < 0.5 else whole


def _sides(
    rng: np.random.Generator, left: bool, right: bool, width: float, depth: float, under: float
) -> list[TriangleMesh]:
    """Pedestals of drawers where wanted; panels or legs elsewhere."""
    if not left and not right and rng.random() < 0.6:
        thick = rng.uniform(0.04, 0.07)
        span = (width * 0.95 - thick, depth * 0.92 - thick)
        return [four_legs(rng, span, under, thick)]
    parts = []
    wide = rng.uniform(0.36, 0.46) if width > 1.3 else rng.uniform(0.3, 0.36)
    hanging = rng.random() < 0.25
    inset = rng.uniform(0.0, 0.04)
    for side, filled in ((-1, left), (1, right)):
        if filled:
            x = side * (width / 2 - inset - wide / 2)
            parts.append(_pedestal(rng, x, wide, depth * 0.94, under, hanging))
        if not filled or hanging:
            x = side * (width / 2 - inset - 0.02)
            parts.append(box((0.035, depth * 0.94, under), (x, 0.0, 0.0)))
    return parts


def _pedestal(
    rng: np.random.Generator, x: float, wide: float, depth: float, under: float, hanging: bool
) -> TriangleMesh:
    """A box of drawers at `x`, on the floor or hanging from the top."""
    base = under * rng.uniform(0.3, 0.55) if hanging else rng.choice([0.0, 0.05])
    rows = int(rng.integers(2, 5)) if not hanging else int(rng.integers(1, 3))
    body = box((wide, depth, under - base), (x, 0.0, base))
    fronts = drawer_fronts(rng, (wide, under - base), -depth / 2, (1, rows))
    return joined([body, moved(fronts, (x, 0.0, base))])


def _middle_drawer(
    rng: np.random.Generator, wide: float, depth: float, under: float
) -> TriangleMesh:
    """A flat drawer above the knees."""
    flat = rng.uniform(0.07, 0.12)
    return box((wide, depth * 0.7, flat), (0.0, -depth * 0.1, under - flat))


def _hutch(rng: np.random.Generator, width: float, depth: float) -> TriangleMesh:
    """Shelves that stand on the back of the top."""
    tall = rng.uniform(0.25, 0.75)
    deep = min(0.35, depth * rng.uniform(0.3, 0.5))
    y = depth / 2 - deep / 2
    columns = int(rng.integers(2, 5))
    parts = [box((_BOARD, deep, tall), (x, y, 0.0)) for x in _evenly(width, columns + 1)]
    for level in np.linspace(tall / int(rng.integers(1, 4)), tall, 2)[: 1 if tall < 0.4 else 2]:
        parts.append(box((width, deep, _BOARD), (0.0, y, level - _BOARD)))
    if rng.random() < 0.7:
        parts.append(box((width, 0.01, tall), (0.0, depth / 2 - 0.005, 0.0)))
    return joined(parts)


def _evenly(width: float, count: int) -> np.ndarray:
    return np.linspace(-(width - _BOARD) / 2, (width - _BOARD) / 2, count)


def _return(
    rng: np.random.Generator, width: float, depth: float, height: float, thickness: float
) -> TriangleMesh:
    """The short arm of an L-shaped desk, towards the user on the right."""
    wide = rng.uniform(0.45, 0.6)
    long = rng.uniform(0.6, 1.1)
    x = width / 2 - wide / 2
    y = -depth / 2 - long / 2
    under = height - thickness
    top = box((wide, long, thickness), (x, y, under))
    end = box((wide * 0.95, 0.03, under), (x, y - long / 2 + 0.03, 0.0))
    back = box((0.02, long, under * 0.7), (width / 2 - 0.03, y, under * 0.3))
    return joined([top, end, back])
