"""Toilets: a bowl on a pedestal, seat and lid, and a tank behind."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.outlines import egg
from circumspect.furniture.placement import joined, turned
from circumspect.furniture.primitives import prism, rounded_box, stacked
from circumspect.geometry import TriangleMesh


def toilet(rng: np.random.Generator) -> TriangleMesh:
    """A toilet with its tank to +y, rim about 0.4 m high."""
    width = rng.uniform(0.34, 0.4)
    length = rng.uniform(0.45, 0.54)
    rim = rng.uniform(0.36, 0.43)
    parts = [_bowl(rng, width, length, rim)]
    deep = rng.uniform(0.16, 0.22)
    tank = (rng.uniform(0.38, 0.5), deep, rng.uniform(0.3, 0.42))
    y = length / 2 + deep / 2 - 0.02
    parts.append(rounded_box(tank, (0.0, y, rim - 0.01), 0.03))
    lid = (tank[0] + 0.02, tank[1] + 0.02, 0.03)
    parts.append(rounded_box(lid, (0.0, y, rim + tank[2] - 0.01), 0.01))
    parts.append(rounded_box((0.22, deep + 0.1, rim * 0.98), (0.0, y - 0.05, 0.0), 0.02))
    cover = prism(egg(width, length * 0.95, 0.25), 0.02, (0.0, -0.01, rim))
    if rng.random() < 0.5:
        parts.append(cover)
    else:
        hinge = (0.0, length / 2 - 0.03, rim)
        parts.append(turned(cover, -rng.uniform(1.4, 1.7), "x", hinge))
    return joined(parts)


def _bowl(rng: np.random.Generator, width: float, length: float, rim: float) -> TriangleMesh:
    """Outside from the foot to the rim, then inside down to the water."""
    foot = rng.uniform(0.55, 0.75)
    outline = egg(width, length, 0.25)
    scales = np.array([foot, foot * 0.9, foot, 0.95, 1.0, 1.0, 0.78, 0.72, 0.5, 0.2])
    levels = np.array([0.0, 0.25, 0.5, 0.85, 0.93, 1.0, 1.0, 0.9, 0.6, 0.5]) * rim
    return stacked(outline[None] * scales[:, None, None], levels)
