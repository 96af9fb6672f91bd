"""What carries a chair: legs, a swivel star, a disc, bent tubes, panels."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from circumspect.furniture.legs import four_legs, star_base
from circumspect.furniture.placement import both_sides, four_corners, joined
from circumspect.furniture.primitives import box, cylinder, revolved, tube
from circumspect.furniture.sheets import smooth_path
from circumspect.geometry import TriangleMesh


class SeatLike(Protocol):
    """The measures of a seat that its base must fit [m]."""

    @property
    def width(self) -> float:
        """Of the seat."""
        ...

    @property
    def depth(self) -> float:
        """Of the seat."""
        ...

    @property
    def height(self) -> float:
        """Of the seat's upper side."""
        ...

    @property
    def under(self) -> float:
        """Height of the seat's underside."""
        ...

    @property
    def spread(self) -> float:
        """Share of width and depth at which legs and posts still meet the seat."""
        ...


def base(rng: np.random.Generator, seat: SeatLike, kind: str | None = None) -> TriangleMesh:
    """The base of a chair.

    Args:
        rng: Draws the kind and its details.
        seat: What to carry.
        kind: "legs", "swivel", "disc", "cantilever", "sled" or "panels"; None draws one.
    """
    kinds = ["legs", "swivel", "disc", "cantilever", "sled", "panels"]
    kind = kind or str(rng.choice(kinds, p=[0.56, 0.16, 0.06, 0.1, 0.08, 0.04]))
    if kind == "swivel":
        return _swivel(rng, seat)
    if kind == "disc":
        return _disc(rng, seat)
    if kind == "cantilever":
        return _cantilever(rng, seat)
    if kind == "sled":
        return _sled(rng, seat)
    if kind == "panels":
        side = box(
            (0.03, seat.depth * 0.9, seat.under), (seat.width / 2 * seat.spread - 0.02, 0, 0)
        )
        return both_sides(side)
    return _legs(rng, seat)


def _legs(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """Four legs, perhaps with rails below the seat or rungs near the floor."""
    thick = rng.uniform(0.025, 0.05)
    span = (seat.width * seat.spread - thick, seat.depth * seat.spread - thick)
    parts = [four_legs(rng, span, seat.under + 0.005, thick)]
    x, y = span[0] / 2, span[1] / 2
    if rng.random() < 0.35:
        level = rng.uniform(0.2, 0.5) * seat.under
        rung = 0.55 * thick
        parts.append(both_sides(tube([(x, -y, level), (x, y, level)], rung, 4)))
        if rng.random() < 0.5:
            parts.append(tube([(-x, 0.0, level), (x, 0.0, level)], rung, 4))
        else:
            parts.append(both_sides(tube([(-x, y, level), (x, y, level)], rung, 4), "y"))
    if rng.random() < 0.4:
        deep = rng.uniform(0.04, 0.08)
        z = seat.under - deep
        parts.append(both_sides(box((0.4 * thick, span[1], deep), (x, 0.0, z))))
        parts.append(both_sides(box((span[0], 0.4 * thick, deep), (0.0, y, z)), "y"))
    return joined(parts)


def _swivel(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """An office chair's star with a gas lift."""
    reach = rng.uniform(0.24, 0.34)
    hub = rng.uniform(0.08, 0.13)
    star = star_base(rng, int(rng.choice([4, 5], p=[0.2, 0.8])), reach, hub, rng.random() < 0.75)
    lift = revolved(
        [(0.028, hub), (0.028, 0.6 * seat.under), (0.018, 0.62 * seat.under), (0.018, seat.under)]
    )
    plate = box((0.2, 0.24, 0.03), (0.0, 0.0, seat.under - 0.025))
    return joined([star, lift, plate])


def _disc(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """A round foot and a column; as a trumpet it is the foot of a tulip chair."""
    reach = rng.uniform(0.2, 0.28)
    column = rng.uniform(0.02, 0.04)
    if rng.random() < 0.5:
        plate = rng.uniform(0.01, 0.03)
        return joined([cylinder(2 * reach, plate), cylinder(2 * column, seat.under)])
    shares = np.linspace(0.0, 1.0, 9)
    radii = column + (reach - column) * (1 - shares) ** 5 + 0.06 * shares**8
    return revolved(np.stack([radii, shares * seat.under + 0.004 * (shares > 0)], axis=1))


def _cantilever(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """One bent tube: a loop on the floor, up at the front, under the seat to the back."""
    pipe = rng.uniform(0.02, 0.035)
    x, y = seat.width / 2 * min(seat.spread + 0.04, 1.0) - pipe / 2, seat.depth / 2
    low, high = pipe / 2, seat.under - pipe / 4
    corners = [(0.0, y, low), (x, y, low), (x, -y, low), (x, -y, high), (x, y * 0.8, high)]
    return both_sides(tube(smooth_path(corners, 0.08), pipe))


def _sled(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """A closed loop on either side, its lower bar lying on the floor."""
    pipe = rng.uniform(0.015, 0.03)
    x = seat.width / 2 * seat.spread - pipe
    y = seat.depth / 2 * seat.spread
    out = rng.uniform(0.0, 0.08)
    low, high = pipe / 2, seat.under
    half = [(x, 0.0, low), (x + 0.2 * out, y + out, low), (x, y, high), (x, 0.0, high)]
    return four_corners(tube(smooth_path(half, 0.05), pipe))
