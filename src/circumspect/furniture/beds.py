"""Beds: a mattress on a frame, box spring or slats, with boards, posts and pillows."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.placement import both_sides, joined
from circumspect.furniture.primitives import box, leg, pillow, rounded_box, strip
from circumspect.geometry import TriangleMesh


def bed(rng: np.random.Generator) -> TriangleMesh:
    """A bed with its head at +y, 0.8 to 2 m wide and about 2 m long."""
    width = float(rng.choice([0.9, 1.2, 1.4, 1.6, 1.8, 2.0])) * rng.uniform(0.95, 1.05)
    length = rng.uniform(1.85, 2.1)
    lift = rng.choice([0.0, rng.uniform(0.08, 0.3)])
    frame = rng.uniform(0.1, 0.3)
    mattress = rng.uniform(0.14, 0.28)
    top = lift + frame + mattress
    parts = [
        box((width, length, frame), (0.0, 0.0, lift)),
        rounded_box(
            (width * 0.97, length * 0.98, mattress + 0.01), (0, 0, lift + frame - 0.01), 0.05
        ),
        _pillows(rng, width, length, top),
    ]
    if lift > 0:
        parts.append(_legs(rng, width, length, lift))
    if rng.random() < 0.85:
        parts.append(_board(rng, width, length / 2, top + rng.uniform(0.15, 0.7)))
    if rng.random() < 0.4:
        parts.append(_board(rng, width, -length / 2 - 0.05, top + rng.uniform(-0.05, 0.25)))
    return joined(parts)


def _legs(rng: np.random.Generator, width: float, length: float, lift: float) -> TriangleMesh:
    thick = rng.uniform(0.05, 0.1)
    x, y = width / 2 - thick, length / 2 - thick
    ends = [leg((x, s * y, 0.0), (x, s * y, lift), thick * 0.8, thick) for s in (-1, 1)]
    return both_sides(joined(ends))


def _board(rng: np.random.Generator, width: float, y: float, tall: float) -> TriangleMesh:
    """A head or foot board at `y`, straight or arched."""
    rise = rng.choice([0.0, rng.uniform(0.05, 0.2)]) * tall
    x = np.linspace(-width / 2 - 0.02, width / 2 + 0.02, 17)
    upper = tall - rise * (x / x[-1]) ** 2
    return strip(x, 0.0, upper, y, y + rng.uniform(0.03, 0.1))


def _pillows(rng: np.random.Generator, width: float, length: float, top: float) -> TriangleMesh:
    count = 1 if width < 1.3 else 2
    wide = min(0.7, 0.85 * width / count)
    deep = rng.uniform(0.38, 0.5)
    y = length / 2 - deep / 2 - 0.05
    places = (np.arange(count) - (count - 1) / 2) * (width * 0.95 / count)
    thick = rng.uniform(0.1, 0.18)
    return joined([pillow((wide, deep, thick), (x, y, top - 0.02)) for x in places])
