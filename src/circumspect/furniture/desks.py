"""Desks: a top on drawer pedestals, panels or legs, with modesty panel, hutch or return."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.drawers import DrawerStyle, carcass
from circumspect.furniture.legs import four_legs
from circumspect.furniture.placement import both_sides, joined, mirrored, moved
from circumspect.furniture.primitives import box, strip, tube
from circumspect.geometry import TriangleMesh

_BOARD = 0.02


@dataclass(frozen=True)
class _Desk:
    """The measures that all parts share.

    Attributes:
        width, depth: of the top [m].
        height: of its upper side [m].
        thickness: of the top [m].
        style: of all drawers.
    """

    width: float
    depth: float
    height: float
    thickness: float
    style: DrawerStyle

    @property
    def under(self) -> float:
        """Height of the top's underside [m]."""
        return self.height - self.thickness


def desk(rng: np.random.Generator) -> TriangleMesh:
    """A desk, its user sits at -y; 0.9 to 2.1 m wide, 0.7 to 0.8 m high without a hutch."""
    width = rng.uniform(1.0, 1.9)
    this = _Desk(
        width=width,
        depth=float(np.clip(width * rng.uniform(0.38, 0.6), 0.45, 0.95)),
        height=rng.uniform(0.7, 0.8),
        thickness=rng.uniform(0.015, 0.05),
        style=DrawerStyle.drawn(rng),
    )
    parts = [_top(rng, this), *_sides(rng, this)]
    if rng.random() < 0.62:
        parts.append(_modesty_panel(rng, this))
    if rng.random() < 0.3:
        flat = rng.uniform(0.06, 0.13)
        size = (width * rng.uniform(0.3, 0.5), this.depth * 0.7, flat)
        drawer = carcass(rng, size, (1, 1), this.style)
        parts.append(moved(drawer, (0.0, -0.1 * this.depth, this.under - flat)))
    if rng.random() < 0.2:
        parts.append(moved(_hutch(rng, this), (0.0, 0.0, this.height)))
    if rng.random() < 0.2:
        parts.append(_return(rng, this))
    whole = joined(parts)
    return mirrored(whole) if rng.random() < 0.5 else whole


def _top(rng: np.random.Generator, this: _Desk) -> TriangleMesh:
    """A board, straight or with a curve cut out before the user."""
    half = this.depth / 2
    if rng.random() < 0.85:
        return box((this.width, this.depth, this.thickness), (0.0, 0.0, this.under))
    x = np.linspace(-this.width / 2, this.width / 2, 21)
    dent = rng.uniform(-0.2, 0.2) * this.depth * np.cos(np.pi * x / this.width)
    return strip(x, dent - half, half, this.under, this.height, "z")


def _sides(rng: np.random.Generator, this: _Desk) -> list[TriangleMesh]:
    """Pedestals of drawers on both sides, on one, or on none."""
    kind = str(rng.choice(["both", "left", "none"], p=[0.34, 0.38, 0.28]))
    if kind == "none":
        return [_bare_support(rng, this)]
    wide = rng.uniform(0.24, 0.33) * this.width
    inset = rng.uniform(0.0, 0.05)
    # Low pedestals hang from the top, or are the drawer boxes of a writing table.
    hanging = rng.random() < 0.35
    base = this.under * rng.uniform(0.25, 0.75) if hanging else 0.0
    rows = int(rng.integers(1, 3)) if hanging else int(rng.integers(2, 5))
    x = this.width / 2 - inset - wide / 2
    depth = this.depth * rng.uniform(0.85, 0.98)
    pedestal = carcass(rng, (wide, depth, this.under - base), (1, rows), this.style)
    left = moved(pedestal, (-x, 0.0, base))
    parts = [left, mirrored(left)] if kind == "both" else [left]
    if hanging:
        thick = rng.uniform(0.035, 0.07)
        span = (this.width - 2 * inset - thick, depth - thick)
        parts.append(four_legs(rng, span, this.under, thick))
    elif kind == "left":
        parts.append(_free_end(rng, this, this.width / 2 - inset))
    return parts


def _free_end(rng: np.random.Generator, this: _Desk, x: float) -> TriangleMesh:
    """A panel or two legs under the end without drawers."""
    if rng.random() < 0.6:
        return box((0.03, this.depth * 0.95, this.under), (x - 0.02, 0.0, 0.0))
    thick = rng.uniform(0.035, 0.06)
    post = box((thick, thick, this.under), (x - thick / 2, this.depth / 2 - thick, 0.0))
    return both_sides(post, "y")


def _bare_support(rng: np.random.Generator, this: _Desk) -> TriangleMesh:
    """Legs, panels, closed frames of bars, or T-shaped feet."""
    kind = str(rng.choice(["legs", "panels", "frames", "feet"], p=[0.35, 0.3, 0.2, 0.15]))
    thick = rng.uniform(0.03, 0.06)
    x, y = this.width / 2 * 0.95 - thick / 2, this.depth / 2 * 0.94 - thick / 2
    if kind == "legs":
        return four_legs(rng, (2 * x, 2 * y), this.under, thick)
    if kind == "panels":
        return both_sides(box((0.03, this.depth * 0.95, this.under), (x, 0.0, 0.0)))
    half = thick / 2
    if kind == "frames":
        low, high = half, this.under - half
        bars = [
            tube([(x, -y, low), (x, y, low)], thick, 4),
            tube([(x, -y, high), (x, y, high)], thick, 4),
            both_sides(tube([(x, y, 0.0), (x, y, this.under)], thick, 4), "y"),
        ]
    else:
        inner = 0.85 * x
        bars = [
            box((1.5 * thick, 2 * y, thick), (inner, 0.0, 0.0)),
            box((thick, 2.5 * thick, this.under), (inner, 0.2 * y, 0.0)),
            box((thick, 1.5 * y, thick), (inner, 0.0, this.under - thick)),
        ]
    beam = box((2 * x, thick, thick), (0.0, 0.3 * y, this.under * 0.8))
    return joined([both_sides(joined(bars)), beam])


def _modesty_panel(rng: np.random.Generator, this: _Desk) -> TriangleMesh:
    """A board before the knees, at the back."""
    drop = this.under * float(rng.choice([0.3, 0.55, 0.8, 1.0]))
    y = this.depth / 2 - rng.uniform(0.03, 0.15)
    return box((this.width * 0.93, _BOARD, drop), (0.0, y, this.under - drop))


def _hutch(rng: np.random.Generator, this: _Desk) -> TriangleMesh:
    """Shelves that stand on the back of the top, across all of it or at one side."""
    tall = rng.uniform(0.2, 0.8)
    deep = rng.uniform(0.2, 0.34)
    wide = this.width * float(rng.choice([1.0, rng.uniform(0.3, 0.6)], p=[0.7, 0.3]))
    uprights = int(rng.integers(2, 6))
    levels = int(rng.integers(1, 4)) if tall > 0.35 else 1
    y = this.depth / 2 - deep / 2
    reach = (wide - _BOARD) / 2
    parts = [box((_BOARD, deep, tall), (x, y, 0.0)) for x in np.linspace(-reach, reach, uprights)]
    for level in np.linspace(0.0, tall, levels + 1)[1:]:
        parts.append(box((wide, deep, _BOARD), (0.0, y, level - _BOARD)))
    if rng.random() < 0.6:
        parts.append(box((wide, 0.01, tall), (0.0, this.depth / 2 - 0.005, 0.0)))
    return moved(joined(parts), ((wide - this.width) / 2, 0.0, 0.0))


def _return(rng: np.random.Generator, this: _Desk) -> TriangleMesh:
    """The short arm of an L-shaped desk, towards the user at +x."""
    wide = rng.uniform(0.4, 0.65)
    long = rng.uniform(0.5, 1.2)
    x = this.width / 2 - wide / 2
    y = -this.depth / 2 - long / 2
    top = box((wide, long, this.thickness), (x, y, this.under))
    parts = [top]
    if rng.random() < 0.5:
        parts.append(box((wide * 0.95, 0.03, this.under), (x, y - long / 2 + 0.03, 0.0)))
    else:
        size = (wide * 0.95, min(0.45, 0.8 * long), this.under)
        chest = carcass(rng, size, (1, int(rng.integers(2, 4))), this.style)
        parts.append(moved(chest, (x, y - long / 2 + size[1] / 2, 0.0)))
    if rng.random() < 0.6:
        drop = this.under * rng.uniform(0.4, 1.0)
        parts.append(box((_BOARD, long, drop), (this.width / 2 - 0.04, y, this.under - drop)))
    return joined(parts)
