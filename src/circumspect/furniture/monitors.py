"""Monitors: a flat panel on a stand, or a tube in its case."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.outlines import ellipse, rounded_rectangle
from circumspect.furniture.placement import joined, moved, turned
from circumspect.furniture.primitives import box, cylinder, prism, stacked, tube
from circumspect.geometry import TriangleMesh


def monitor(rng: np.random.Generator) -> TriangleMesh:
    """A computer screen that looks to -y, 0.35 to 0.8 m wide."""
    if rng.random() < 0.22:
        return _tube_monitor(rng)
    width = rng.uniform(0.4, 0.75)
    tall = width * rng.choice([9 / 16, 10 / 16, 3 / 4], p=[0.5, 0.3, 0.2])
    lift = rng.uniform(0.04, 0.16)
    panel = moved(_panel(rng, width, tall), (0.0, 0.0, lift))
    tilt = rng.choice([0.0, rng.uniform(0.0, 0.15)])
    back = 0.03 + rng.uniform(0.02, 0.06)
    middle = lift + tall * rng.uniform(0.35, 0.5)
    parts = [turned(panel, -tilt, "x", (0.0, 0.0, middle)), _stand(rng, width, back, middle)]
    return joined(parts)


def _panel(rng: np.random.Generator, width: float, tall: float) -> TriangleMesh:
    """The screen with its bezel, and often a smaller box of electronics behind it."""
    thick = rng.uniform(0.02, 0.06)
    bezel = rng.uniform(0.01, 0.035)
    lip = 0.006
    parts = [box((width, thick, tall))]
    for side in (-1, 1):
        parts.append(box((bezel, lip, tall), (side * (width - bezel) / 2, -thick / 2, 0.0)))
    for base in (0.0, tall - bezel):
        parts.append(box((width, lip, bezel), (0.0, -thick / 2, base)))
    if rng.random() < 0.5:
        shy = rng.uniform(0.5, 0.85)
        hump = rng.uniform(0.02, 0.05)
        y = (thick + hump) / 2
        parts.append(box((width * shy, hump, tall * shy), (0.0, y, tall * (1 - shy) / 2)))
    return joined(parts)


def _stand(rng: np.random.Generator, width: float, back: float, middle: float) -> TriangleMesh:
    """A foot on the desk and a neck up to the back of the panel."""
    reach = width * rng.uniform(0.3, 0.55)
    plate = rng.uniform(0.008, 0.02)
    kind = str(rng.choice(["disc", "rectangle", "two feet"], p=[0.4, 0.4, 0.2]))
    if kind == "disc":
        foot = prism(ellipse(reach, reach * rng.uniform(0.6, 1.0)), plate)
    elif kind == "rectangle":
        foot = prism(rounded_rectangle(reach, reach * rng.uniform(0.5, 0.8), 0.02), plate)
    else:
        rod = [(0.0, back, plate), (reach / 2, -0.09, plate / 2)]
        left = [(0.0, back, plate), (-reach / 2, -0.09, plate / 2)]
        foot = joined([tube(rod, plate, 4), tube(left, plate, 4)])
    neck_wide = rng.uniform(0.03, 0.1)
    neck = box((neck_wide, 0.02, middle), (0.0, back, 0.0))
    arm = box((neck_wide, back, 0.05), (0.0, back / 2, middle - 0.05))
    return joined([foot, neck, arm])


def _tube_monitor(rng: np.random.Generator) -> TriangleMesh:
    """A cathode ray tube: a case that narrows to the back, on a swivel foot."""
    width = rng.uniform(0.34, 0.5)
    tall = width * rng.uniform(0.75, 0.95)
    deep = width * rng.uniform(0.75, 1.1)
    shares = np.array([1.0, 1.0, rng.uniform(0.7, 0.9), rng.uniform(0.5, 0.65)])
    outline = rounded_rectangle(width, tall, 0.02)
    levels = np.array([0.0, 0.3, 0.55, 1.0]) * deep
    case = turned(stacked(outline[None] * shares[:, None, None], levels), -np.pi / 2, "x")
    lift = rng.choice([0.0, rng.uniform(0.03, 0.08)])
    body = moved(case, (0.0, -deep / 2, tall / 2 + lift))
    if lift == 0.0:
        return body
    foot = cylinder(width * rng.uniform(0.5, 0.7), lift + 0.02, (0.0, -0.1 * deep, 0.0))
    return joined([body, foot])
