"""Beds: a mattress on a frame or box spring, with boards, posts, bedding and pillows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.legs import turned_leg
from circumspect.furniture.placement import both_sides, four_corners, joined, moved
from circumspect.furniture.primitives import box, leg, pillow, rounded_box, strip, tube
from circumspect.furniture.sheets import sheet
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True)
class _Bed:
    """The measures that all parts share.

    Attributes:
        width, length: of the frame [m].
        lift: of the frame above the floor [m].
        frame: height of the frame or box spring itself [m].
        mattress: its thickness [m].
    """

    width: float
    length: float
    lift: float
    frame: float
    mattress: float

    @property
    def top(self) -> float:
        """Height of the mattress's upper side [m]."""
        return self.lift + self.frame + self.mattress


def bed(rng: np.random.Generator) -> TriangleMesh:
    """A bed with its head at +y, 0.85 to 2 m wide and about 2 m long."""
    single, double = rng.uniform(0.85, 1.15), rng.uniform(1.35, 2.0)
    this = _Bed(
        width=single if rng.random() < 0.3 else double,
        length=rng.uniform(1.85, 2.15),
        lift=float(rng.choice([0.0, rng.uniform(0.06, 0.32)], p=[0.35, 0.65])),
        frame=rng.uniform(0.08, 0.3),
        mattress=rng.uniform(0.12, 0.28),
    )
    parts = [_frame(rng, this), _mattress(this)]
    if this.lift > 0:
        parts.append(_legs(rng, this))
    parts += _ends(rng, this)
    if rng.random() < 0.55:
        parts.append(_blanket(rng, this))
    if rng.random() < 0.82:
        parts.append(_pillows(rng, this))
    if rng.random() < 0.08:
        parts.append(_side_tables(rng, this))
    return joined(parts)


def _frame(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    """A soft box spring, or rails round a slatted base that stand a little proud."""
    size = (this.width, this.length, this.frame)
    if rng.random() < 0.5:
        return rounded_box(size, (0.0, 0.0, this.lift), 0.03)
    out = rng.uniform(0.0, 0.06)
    return box((size[0] + 2 * out, size[1] + out, size[2]), (0.0, 0.0, this.lift))


def _mattress(this: _Bed) -> TriangleMesh:
    size = (this.width * 0.98, this.length * 0.985, this.mattress + 0.01)
    return rounded_box(size, (0.0, 0.0, this.lift + this.frame - 0.01), 0.05)


def _legs(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    thick = rng.uniform(0.05, 0.11)
    x, y = this.width / 2 - thick / 2, this.length / 2 - thick / 2
    taper = rng.uniform(0.5, 1.0)
    return four_corners(leg((x, y, 0.0), (x, y, this.lift + 0.01), thick * taper, thick))


def _ends(rng: np.random.Generator, this: _Bed) -> list[TriangleMesh]:
    """Head and foot boards, or four posts and what they carry."""
    if rng.random() < 0.05:
        return [_four_posts(rng, this), _board(rng, this, "panel", this.top + 0.5, head=True)]
    kinds = ["panel", "arched", "padded", "bars", "sleigh", "none"]
    kind = str(rng.choice(kinds, p=[0.26, 0.22, 0.16, 0.16, 0.08, 0.12]))
    if kind == "none":
        return []
    parts = [_board(rng, this, kind, this.top + rng.uniform(0.12, 0.85), head=True)]
    if rng.random() < 0.45:
        parts.append(_board(rng, this, kind, this.top + rng.uniform(-0.08, 0.3), head=False))
    return parts


def _board(
    rng: np.random.Generator, this: _Bed, kind: str, tall: float, head: bool
) -> TriangleMesh:
    """A board across one end, from the floor (or the frame) to the height `tall`."""
    out = rng.uniform(0.0, 0.12) if head else 0.02
    half = this.width / 2 + out
    thick = rng.uniform(0.03, 0.09)
    low = float(rng.choice([0.0, this.lift]))
    if kind == "padded":
        soft = rounded_box((2 * half, thick * 1.6, tall - low), (0.0, thick, low), 0.03)
        made = soft
    elif kind == "bars":
        made = _bars(rng, half, tall)
    elif kind == "sleigh":
        made = _sleigh(rng, half, low, tall)
    else:
        x = np.linspace(-half, half, 21)
        rise = rng.uniform(0.1, 0.35) * (tall - this.lift) if kind == "arched" else 0.0
        swing = np.abs(x / half) ** rng.uniform(1.5, 4.0)
        made = strip(x, low, tall - rise * swing, 0.0, thick)
        if rng.random() < 0.4:
            post_tall = tall - rise + rng.uniform(0.0, 0.1)
            post = leg((half, thick / 2, 0.0), (half, thick / 2, post_tall), 0.07, 0.07)
            made = joined([made, both_sides(post)])
    if head:
        return moved(made, (0.0, this.length / 2 - 0.005, 0.0))
    flipped = TriangleMesh(made.vertices_xyz * (1.0, -1.0, 1.0), made.faces[:, ::-1])
    return moved(flipped, (0.0, -this.length / 2 + 0.005, 0.0))


def _bars(rng: np.random.Generator, half: float, tall: float) -> TriangleMesh:
    """Posts, two rails and upright bars, the upper rail straight or bowed."""
    thick = rng.uniform(0.03, 0.07)
    crown = rng.uniform(0.0, 0.2)
    x = np.linspace(-half, half, 13)
    z = tall - crown * (x / half) ** 2
    y = np.full(13, thick / 2)
    low = rng.uniform(0.2, 0.4)
    count = int(rng.integers(4, 13))
    parts = [
        tube(np.stack([x, y, z], axis=1), thick * 0.8),
        tube([(-half, thick / 2, low), (half, thick / 2, low)], thick * 0.8, 4),
        both_sides(
            leg((half, thick / 2, 0.0), (half, thick / 2, tall - crown + 0.06), thick, thick)
        ),
    ]
    for place in np.linspace(-half, half, count + 2)[1:-1]:
        high = tall - crown * (place / half) ** 2
        parts.append(tube([(place, thick / 2, low), (place, thick / 2, high)], thick * 0.45, 6))
    return joined(parts)


def _sleigh(rng: np.random.Generator, half: float, low: float, tall: float) -> TriangleMesh:
    """A board that curls outwards at its top."""
    shares = np.linspace(0.0, 1.0, 10)
    curl = rng.uniform(0.1, 0.25)
    points = np.empty((10, 2, 3))
    points[..., 0] = (-half, half)
    points[..., 1] = (0.02 + curl * shares**2.5)[:, None]
    points[..., 2] = (low + (tall - low) * np.sin(shares * 1.45) / np.sin(1.45))[:, None]
    return sheet(points, 0.05)


def _four_posts(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    """A post at each corner, with the bars of a canopy or without."""
    tall = rng.uniform(1.4, 2.1)
    thick = rng.uniform(0.05, 0.09)
    x, y = this.width / 2, this.length / 2
    if rng.random() < 0.5:
        post = leg((x, y, 0.0), (x, y, tall), thick, thick)
    else:
        post = turned_leg(rng, (x, y, 0.0), tall, thick)
    parts = [four_corners(post)]
    if rng.random() < 0.6:
        rod = thick * 0.7
        high = tall - rod / 2
        parts.append(both_sides(tube([(x, -y, high), (x, y, high)], rod, 4)))
        parts.append(both_sides(tube([(-x, y, high), (x, y, high)], rod, 4), "y"))
    return joined(parts)


def _blanket(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    """A cover over the lower part that hangs down the sides and the foot."""
    share = rng.uniform(0.5, 0.8)
    long = this.length * share
    drop = this.mattress + rng.uniform(0.0, 0.8) * this.frame
    out = rng.uniform(0.01, 0.03)
    size = (this.width + 2 * out, long, drop + 0.03)
    y = -(this.length - long) / 2 - out
    return rounded_box(size, (0.0, y, this.top - drop), 0.04)


def _pillows(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    count = 1 if this.width < 1.3 else 2
    wide = min(0.75, 0.9 * this.width / count)
    deep = rng.uniform(0.36, 0.5)
    thick = rng.uniform(0.09, 0.2)
    y = this.length / 2 - deep / 2 - 0.04
    places = (np.arange(count) - (count - 1) / 2) * (this.width * 0.96 / count)
    layers = int(rng.choice([1, 2], p=[0.8, 0.2]))
    return joined(
        [
            pillow((wide, deep, thick), (x, y - 0.06 * k, this.top - 0.015 + 0.7 * thick * k))
            for x in places
            for k in range(layers)
        ]
    )


def _side_tables(rng: np.random.Generator, this: _Bed) -> TriangleMesh:
    """A small cabinet on either side of the head."""
    wide = rng.uniform(0.35, 0.5)
    tall = this.top * rng.uniform(0.75, 1.1)
    deep = rng.uniform(0.35, 0.45)
    x = this.width / 2 + 0.03 + wide / 2
    return both_sides(box((wide, deep, tall), (x, this.length / 2 - deep / 2, 0.0)))
