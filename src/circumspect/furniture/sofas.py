"""Sofas: seats between arms before a back, some with a chaise."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import four_legs
from circumspect.furniture.placement import both_sides, joined, mirrored
from circumspect.furniture.primitives import rounded_box
from circumspect.geometry import TriangleMesh


def sofa(rng: np.random.Generator) -> TriangleMesh:
    """A sofa, its back to +y, for two to four people."""
    seats = int(rng.choice([2, 3, 4], p=[0.4, 0.45, 0.15]))
    seat_wide = rng.uniform(0.55, 0.75)
    arm = rng.choice([0.0, rng.uniform(0.12, 0.3)], p=[0.12, 0.88])
    inner = seats * seat_wide
    width = inner + 2 * arm
    depth = rng.uniform(0.8, 1.0)
    lift = rng.choice([0.0, rng.uniform(0.05, 0.15)])
    base = rng.uniform(0.18, 0.28)
    seat = lift + base + rng.uniform(0.1, 0.2)
    back_high = rng.uniform(0.65, 0.95)
    back = rng.uniform(0.15, 0.28)
    soft = rng.uniform(0.02, 0.06)
    parts = [
        rounded_box((width, depth, base), (0.0, 0.0, lift), 0.02),
        rounded_box((width, back, back_high - lift), (0.0, (depth - back) / 2, lift), soft),
    ]
    deep = depth - back
    y = -back / 2
    places = (np.arange(seats) - (seats - 1) / 2) * seat_wide
    for x in places:
        size = (seat_wide * 0.99, deep, seat - lift - base)
        parts.append(rounded_box(size, (x, y, lift + base), soft))
    if rng.random() < 0.7:
        thick = rng.uniform(0.1, 0.2)
        for x in places:
            size = (seat_wide * 0.97, thick, (back_high - seat) * rng.uniform(0.8, 1.1))
            parts.append(rounded_box(size, (x, (depth / 2 - back - thick / 2), seat), soft))
    if arm > 0:
        high = seat + rng.uniform(0.1, 0.25)
        block = rounded_box((arm, depth, high - lift), ((width - arm) / 2, 0.0, lift), soft)
        parts.append(both_sides(block))
    if lift > 0:
        parts.append(four_legs(rng, (width - 0.12, depth - 0.12), lift, 0.05))
    if rng.random() < 0.2:
        long = rng.uniform(0.5, 0.9)
        x = (width - seat_wide) / 2 - arm
        place = (x, -depth / 2 - long / 2 + 0.05, lift)
        parts.append(rounded_box((seat_wide, long + 0.1, seat - lift), place, soft))
    whole = joined(parts)
    return mirrored(whole) if rng.random() < 0.5 else whole
