"""Chairs: a seat, a back and what carries them."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import four_legs, star_base
from circumspect.furniture.outlines import ellipse, rounded_rectangle
from circumspect.furniture.placement import both_sides, joined, turned
from circumspect.furniture.primitives import cylinder, rounded_box, slab, tube
from circumspect.geometry import TriangleMesh


def chair(rng: np.random.Generator) -> TriangleMesh:
    """A chair with its back to +y, seat about 0.45 m high."""
    width = rng.uniform(0.4, 0.56)
    depth = width * rng.uniform(0.9, 1.1)
    seat = rng.uniform(0.42, 0.5)
    thick = rng.uniform(0.02, 0.09)
    under = seat - thick
    if rng.random() < 0.2:
        outline = ellipse(width, depth)
    else:
        outline = rounded_rectangle(width, depth, rng.uniform(0.01, 0.3) * width)
    parts = [slab(outline, thick, (0.0, 0.0, under), thick * 0.4)]
    base = str(rng.choice(["legs", "swivel", "cantilever"], p=[0.65, 0.22, 0.13]))
    if base == "legs":
        width_leg = rng.uniform(0.025, 0.05)
        parts.append(four_legs(rng, (width - 0.08, depth - 0.08), under, width_leg))
    elif base == "swivel":
        reach = rng.uniform(0.26, 0.34)
        star = star_base(rng, 5, reach, 0.1, wheels=True)
        parts += [star, cylinder(0.05, under - 0.08, (0.0, 0.0, 0.08))]
    else:
        parts.append(_cantilever(rng, width, depth, under))
    parts.append(_back(rng, width, depth, seat))
    if rng.random() < 0.4:
        parts.append(_arms(rng, width, depth, seat))
    return joined(parts)


def _cantilever(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two bent tubes: along the floor, up at the front, under the seat."""
    pipe = rng.uniform(0.02, 0.035)
    x, y = width / 2 - pipe, depth / 2
    path = [
        (x, y, pipe / 2),
        (x, -y, pipe / 2),
        (x, -y, under - pipe / 2),
        (x, y, under - pipe / 2),
    ]
    rear = tube([(-x, y, pipe / 2), (x, y, pipe / 2)], pipe)
    legs = [tube([path[k], path[k + 1]], pipe) for k in range(3)]
    return joined([both_sides(joined(legs)), rear])


def _back(rng: np.random.Generator, width: float, depth: float, seat: float) -> TriangleMesh:
    """A panel, or slats between two posts, leaning backwards."""
    tall = rng.uniform(0.36, 0.58)
    lean = rng.uniform(0.0, 0.25)
    y = depth / 2 - 0.02
    kind = str(rng.choice(["solid", "slats", "ladder"], p=[0.5, 0.25, 0.25]))
    if kind == "solid":
        low = rng.choice([0.0, rng.uniform(0.05, 0.2)])
        thick = rng.uniform(0.02, 0.07)
        parts = [rounded_box((width * 0.95, thick, tall - low), (0.0, y, seat + low), thick * 0.4)]
        if low > 0:
            post = tube([(width * 0.3, y, seat - 0.02), (width * 0.3, y, seat + low + 0.1)], 0.03)
            parts.append(both_sides(post))
    else:
        x = width / 2 - 0.03
        parts = [both_sides(tube([(x, y, seat - 0.02), (x, y, seat + tall)], 0.035, 4))]
        count = int(rng.integers(3, 7))
        if kind == "slats":
            parts.append(
                rounded_box((width - 0.04, 0.025, 0.07), (0.0, y, seat + tall - 0.07), 0.01)
            )
            for place in np.linspace(-x, x, count + 2)[1:-1]:
                parts.append(tube([(place, y, seat), (place, y, seat + tall - 0.03)], 0.02, 6))
        else:
            for level in np.linspace(0.15, 1.0, count) * (tall - 0.06):
                parts.append(rounded_box((2 * x, 0.02, 0.055), (0.0, y, seat + level), 0.008))
    return turned(joined(parts), -lean, "x", (0.0, y, seat))


def _arms(rng: np.random.Generator, width: float, depth: float, seat: float) -> TriangleMesh:
    """An arm rest on a post on either side."""
    high = rng.uniform(0.17, 0.25)
    x = width / 2 + 0.01
    thick = rng.uniform(0.025, 0.045)
    rest = rounded_box((0.05, depth * 0.85, thick), (x, 0.05, seat + high - thick), 0.01)
    post = tube([(x, -depth * 0.25, seat - 0.03), (x, -depth * 0.25, seat + high - 0.01)], thick)
    return both_sides(joined([rest, post]))
