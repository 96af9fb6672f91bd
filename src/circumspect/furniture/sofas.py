"""Sofas: seats between arms before a back, straight or round a corner, some with a chaise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.legs import four_legs
from circumspect.furniture.outlines import ellipse
from circumspect.furniture.placement import both_sides, joined, mirrored, moved, turned
from circumspect.furniture.primitives import box, loft, rounded_box, strip
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True)
class _Sofa:
    """The measures that all parts share.

    Attributes:
        seats: how many people it holds.
        place: width of one seat [m].
        arm: width of an arm [m]; 0 without.
        depth: front to back [m].
        back: thickness of the back [m].
        lift: of the frame above the floor [m].
        base: height of the frame itself [m].
        seat: height of the seat [m].
        high: height of the back [m].
        soft: radius of its edges [m].
    """

    seats: int
    place: float
    arm: float
    depth: float
    back: float
    lift: float
    base: float
    seat: float
    high: float
    soft: float

    @property
    def inner(self) -> float:
        """Width between the arms [m]."""
        return self.seats * self.place

    @property
    def width(self) -> float:
        """Width over all [m]."""
        return self.inner + 2 * self.arm

    @property
    def centres(self) -> np.ndarray:
        """(seats,) [m] x of the middle of each seat."""
        return (np.arange(self.seats) - (self.seats - 1) / 2) * self.place


def sofa(rng: np.random.Generator) -> TriangleMesh:
    """A sofa, its back to +y, for one wide or two to four people."""
    lift = float(rng.choice([0.0, rng.uniform(0.04, 0.18)], p=[0.4, 0.6]))
    base = rng.uniform(0.12, 0.26)
    seat = lift + base + rng.uniform(0.1, 0.2)
    this = _Sofa(
        seats=int(rng.choice([2, 3, 4], p=[0.38, 0.44, 0.18])),
        place=rng.uniform(0.55, 0.8),
        arm=float(rng.choice([0.0, rng.uniform(0.08, 0.3)], p=[0.12, 0.88])),
        depth=rng.uniform(0.78, 1.05),
        back=rng.uniform(0.12, 0.28),
        lift=lift,
        base=base,
        seat=seat,
        high=seat + rng.uniform(0.25, 0.5),
        soft=rng.uniform(0.015, 0.07),
    )
    parts = [
        rounded_box((this.width, this.depth, base), (0.0, 0.0, lift), 0.02),
        _back(rng, this),
        *_seat_cushions(rng, this),
        *_back_cushions(rng, this),
        *_arms(rng, this),
    ]
    if lift > 0:
        thick = rng.uniform(0.035, 0.07)
        style = str(rng.choice(["square", "round", "tapered", "turned"]))
        span = (this.width - 2 * thick, this.depth - 2 * thick)
        parts.append(four_legs(rng, span, lift + 0.01, thick, style))
    turn = str(rng.choice(["straight", "chaise", "corner"], p=[0.76, 0.12, 0.12]))
    if turn != "straight":
        parts.append(_wing(rng, this, with_back=turn == "corner"))
    whole = joined(parts)
    return mirrored(whole) if rng.random() < 0.5 else whole


def _back(rng: np.random.Generator, this: _Sofa) -> TriangleMesh:
    """A block, upright or leaning, or a board with a curved upper edge."""
    kind = str(rng.choice(["block", "leaning", "camel"], p=[0.55, 0.25, 0.2]))
    y = this.depth / 2
    wide = this.width if rng.random() < 0.6 else this.inner
    if kind == "camel":
        x = np.linspace(-wide / 2, wide / 2, 25)
        humps = rng.choice([1, 2])
        wave = 0.5 - 0.5 * np.cos(2 * np.pi * humps * (x / wide + 0.5))
        top = this.high - rng.uniform(0.05, 0.18) * (1 - wave)
        return strip(x, this.lift, top, y - this.back, y)
    block = rounded_box(
        (wide, this.back, this.high - this.lift), (0.0, y - this.back / 2, this.lift), this.soft
    )
    if kind == "block":
        return block
    return turned(block, -rng.uniform(0.05, 0.25), "x", (0.0, y - this.back / 2, this.seat))


def _seat_cushions(rng: np.random.Generator, this: _Sofa) -> list[TriangleMesh]:
    """One cushion a seat, or a single long one."""
    deep = this.depth - this.back + rng.uniform(0.0, 0.04)
    y = this.depth / 2 - this.back - deep / 2
    low = this.lift + this.base
    if rng.random() < 0.25:
        return [rounded_box((this.inner, deep, this.seat - low), (0.0, y, low), this.soft)]
    size = (this.place * 0.995, deep, this.seat - low)
    return [rounded_box(size, (x, y, low), this.soft) for x in this.centres]


def _back_cushions(rng: np.random.Generator, this: _Sofa) -> list[TriangleMesh]:
    if rng.random() < 0.35:
        return []
    thick = rng.uniform(0.1, 0.22)
    tall = (this.high - this.seat) * rng.uniform(0.75, 1.12)
    y = this.depth / 2 - this.back - thick / 2
    lean = rng.uniform(0.0, 0.25)
    parts = []
    for x in this.centres:
        cushion = rounded_box((this.place * 0.97, thick, tall), (x, y, this.seat), 0.3 * thick)
        parts.append(turned(cushion, -lean, "x", (x, y + thick / 2, this.seat)))
    return parts


def _arms(rng: np.random.Generator, this: _Sofa) -> list[TriangleMesh]:
    """Blocks, blocks under a roll, or boards that slope to the front."""
    if this.arm == 0:
        return []
    high = min(this.seat + rng.uniform(0.08, 0.28), this.high)
    x = (this.width - this.arm) / 2
    kind = str(rng.choice(["block", "roll", "slope"], p=[0.55, 0.3, 0.15]))
    if kind == "slope":
        y = np.linspace(-this.depth / 2, this.depth / 2, 9)
        share = (y / this.depth + 0.5) ** rng.uniform(1.0, 3.0)
        top = high + (this.high - high) * share
        half = this.arm / 2
        return [both_sides(strip(y, this.lift, top, x - half, x + half, "x"))]
    block = rounded_box((this.arm, this.depth, high - this.lift), (x, 0.0, this.lift), this.soft)
    if kind == "block":
        return [both_sides(block)]
    roll = ellipse(this.arm * 1.35, this.arm * rng.uniform(0.9, 1.35), 20)
    rings = np.empty((2, 20, 3))
    rings[..., 0] = x + 0.1 * this.arm + roll[:, 0]
    rings[..., 1] = np.array([[this.depth / 2], [-this.depth / 2]])
    rings[..., 2] = high - 0.02 + roll[:, 1]
    return [both_sides(joined([block, loft(rings)]))]


def _wing(rng: np.random.Generator, this: _Sofa, with_back: bool) -> TriangleMesh:
    """The part of an L that runs forward at +x: a chaise, or seats with a back of their own."""
    long = rng.uniform(0.7, 1.5) if with_back else rng.uniform(0.5, 0.9)
    wide = this.depth if with_back else this.place + this.arm
    x = this.width / 2 - wide / 2
    y = -this.depth / 2 - long / 2
    low = this.lift + this.base
    overlap = 0.04
    frame = rounded_box((wide, long + overlap, this.base), (x, y + overlap / 2, this.lift), 0.02)
    deep = wide - (this.back if with_back else 0.0)
    cushion = rounded_box(
        (deep, long + overlap, this.seat - low),
        (x - (wide - deep) / 2, y + overlap / 2, low),
        this.soft,
    )
    parts = [frame, cushion]
    if with_back:
        rest = (this.back, long + overlap, this.high - this.lift)
        place = (this.width / 2 - this.back / 2, y + overlap / 2, this.lift)
        parts.append(rounded_box(rest, place, this.soft))
    if this.lift > 0:
        foot = box((0.05, 0.05, this.lift + 0.01))
        feet = [moved(foot, (x + s * (wide / 2 - 0.06), y - long / 2 + 0.06, 0.0)) for s in (-1, 1)]
        parts += feet
    return joined(parts)
