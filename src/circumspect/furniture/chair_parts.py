"""Parts of chairs: backs (panels, ladders, spindles, hoops, splats) and what carries the seat."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from circumspect.furniture.legs import four_legs, star_base
from circumspect.furniture.placement import both_sides, four_corners, joined, moved, turned
from circumspect.furniture.primitives import box, cylinder, revolved, rounded_box, strip, tube
from circumspect.furniture.sheets import sheet, smooth_path
from circumspect.geometry import TriangleMesh


class SeatLike(Protocol):
    """The measures of a seat that its base must fit [m]."""

    @property
    def width(self) -> float:
        """Width of the seat."""
        ...

    @property
    def depth(self) -> float:
        """Depth of the seat."""
        ...

    @property
    def height(self) -> float:
        """Height of the seat's upper side."""
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


def back_rest(rng: np.random.Generator, seat: SeatLike) -> TriangleMesh:
    """The back of a chair, leaning a little to +y."""
    tall = rng.uniform(0.32, 0.62)
    lean = rng.uniform(0.0, 0.28)
    makers = [_panel, _curved_panel, _frame_back, _hoop]
    make = makers[int(rng.choice(4, p=[0.24, 0.26, 0.36, 0.14]))]
    y = seat.depth / 2 * seat.spread - 0.015
    x = seat.width / 2 * seat.spread - 0.02
    upright = moved(make(rng, x, tall), (0.0, y, seat.height))
    return turned(upright, -lean, "x", (0.0, y, seat.height))


def _panel(rng: np.random.Generator, x: float, tall: float) -> TriangleMesh:
    """A flat pad, its upper edge straight or arched, from the seat or held by posts."""
    low = float(rng.choice([-0.02, rng.uniform(0.06, 0.22)]))
    thick = rng.uniform(0.018, 0.07)
    if rng.random() < 0.5:
        pad = rounded_box((2 * x + 0.03, thick, tall - low), (0.0, 0.0, low), 0.4 * thick)
    else:
        u = np.linspace(-x - 0.015, x + 0.015, 15)
        top = tall - rng.uniform(0.02, 0.14) * (u / x) ** 2
        pad = strip(u, low, top, -thick / 2, thick / 2)
    if low < 0:
        return pad
    gap = x * rng.uniform(0.4, 0.95)
    post = tube([(gap, 0.01, -0.04), (gap, 0.01, low + 0.1)], 0.026, 4)
    return joined([pad, both_sides(post)])


def _curved_panel(rng: np.random.Generator, x: float, tall: float) -> TriangleMesh:
    """A panel bent round the sitter."""
    low = float(rng.choice([-0.02, rng.uniform(0.1, 0.25)]))
    bend = rng.uniform(0.02, 0.12)
    t = np.linspace(-1.0, 1.0, 13)
    arch = rng.uniform(0.0, 0.25) * (tall - low) * t**4
    levels = np.linspace(0.0, 1.0, 5)[:, None]
    points = np.empty((5, 13, 3))
    points[..., 0] = (x + 0.02) * t
    points[..., 1] = 0.02 - bend * t**2
    points[..., 2] = low + (tall - arch - low) * levels
    pad = sheet(points, rng.uniform(0.012, 0.04))
    if low < 0:
        return pad
    gap = 0.6 * x
    near = 0.03 - bend * 0.36
    post = tube([(gap, 0.0, -0.04), (gap, near, low + 0.12)], 0.024)
    return joined([pad, both_sides(post)])


def _frame_back(rng: np.random.Generator, x: float, tall: float) -> TriangleMesh:
    """Two posts with a ladder, spindles, a splat or a crest rail alone between them."""
    thick = rng.uniform(0.022, 0.045)
    sides = int(rng.choice([4, 8]))
    flare = rng.uniform(0.0, 0.04)
    rail = rng.uniform(0.04, 0.12)
    post = tube([(x, 0.0, -0.05), (x + flare, 0.0, tall - 0.2 * rail)], [thick, 0.8 * thick], sides)
    u = np.linspace(-x - flare - 0.01, x + flare + 0.01, 11)
    crown = tall + rng.uniform(0.0, 0.05) * np.cos(u / u[-1] * np.pi / 2)
    half = 0.35 * thick
    parts = [both_sides(post), strip(u, tall - rail, crown, -half, half)]
    kind = str(rng.choice(["ladder", "spindles", "splat", "bare"], p=[0.36, 0.34, 0.18, 0.12]))
    if kind == "ladder":
        deep = rng.uniform(0.03, 0.08)
        count = int(rng.integers(1, 5))
        for level in np.linspace(0.1, 1.0, count + 1)[:-1] * (tall - rail):
            parts.append(rounded_box((2 * x, 0.6 * thick, deep), (0.0, 0.0, level), 0.005))
    elif kind == "spindles":
        parts += _spindles(rng, x, tall - 0.5 * rail)
    elif kind == "splat":
        z = np.linspace(-0.01, tall - 0.5 * rail, 12)
        wave = x * (0.25 + 0.12 * np.sin(z / tall * rng.uniform(5.0, 12.0)))
        splat = strip(z, -wave, wave, -half, half, "y")
        # The strip lies along x; its long axis is wanted upright.
        parts.append(turned(splat, -np.pi / 2, "y"))
    return joined(parts)


def _spindles(rng: np.random.Generator, x: float, tall: float) -> list[TriangleMesh]:
    count = int(rng.integers(3, 8))
    thin = rng.uniform(0.01, 0.018)
    low = float(rng.choice([0.0, 0.12]))
    places = np.linspace(-x, x, count + 2)[1:-1]
    rods = [tube([(u, 0.0, low - 0.01), (u, 0.0, tall)], thin, 6) for u in places]
    if low > 0:
        rods.append(rounded_box((2 * x, 0.018, 0.04), (0.0, 0.0, low - 0.03), 0.004))
    return rods


def _hoop(rng: np.random.Generator, x: float, tall: float) -> TriangleMesh:
    """One bent rod with spindles or a smaller hoop inside."""
    thick = rng.uniform(0.02, 0.035)
    radius = rng.uniform(0.4, 1.0) * x * 1.5
    arch = smooth_path([(-x, 0.0, -0.04), (-x, 0.0, tall), (x, 0.0, tall), (x, 0.0, -0.04)], radius)
    parts = [tube(arch, thick)]
    if rng.random() < 0.4:
        inner = arch * (0.6, 1.0, 0.72)
        parts.append(tube(inner, 0.8 * thick))
    else:
        heights = np.interp(
            places := np.linspace(-x, x, int(rng.integers(3, 8)) + 2)[1:-1], arch[:, 0], arch[:, 2]
        )
        for place, high in zip(places, heights, strict=True):
            parts.append(tube([(place, 0.0, -0.01), (place, 0.0, high)], 0.012, 6))
    return joined(parts)
