"""Bathtubs: a shell with a basin, on an apron, claw feet or its own base."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import four_legs
from circumspect.furniture.outlines import rounded_rectangle
from circumspect.furniture.placement import joined
from circumspect.furniture.primitives import stacked
from circumspect.geometry import TriangleMesh


def bathtub(rng: np.random.Generator) -> TriangleMesh:
    """A bathtub along x, 1.4 to 1.9 m long."""
    length = rng.uniform(1.4, 1.9)
    width = rng.uniform(0.68, 0.95)
    height = rng.uniform(0.45, 0.65)
    shape = str(rng.choice(["oval", "box"]))
    lift = rng.choice([0.0, rng.uniform(0.08, 0.16)]) if shape == "oval" else 0.0
    if shape == "oval":
        outer = rounded_rectangle(length, width, width * rng.uniform(0.3, 0.5), 7)
        foot = rng.uniform(0.65, 0.9)
    else:
        outer = rounded_rectangle(length, width, 0.02, 7)
        foot = 1.0
    rim = rng.uniform(0.04, 0.09)
    inner = rounded_rectangle(length - 2 * rim, width - 2 * rim, width * rng.uniform(0.15, 0.5), 7)
    rings = [outer * foot, outer * (foot + 1) / 2, outer, outer, inner, inner * 0.9, inner * 0.75]
    tall = height - lift
    levels = np.array([0.0, 0.4 * tall, tall - 0.03, tall, tall, 0.5 * tall, 0.15 * tall])
    shell = stacked(rings, levels, (0.0, 0.0, lift))
    if lift == 0.0:
        return shell
    feet = four_legs(rng, (length * 0.55, width * 0.5), lift + 0.06, 0.06, "curved")
    return joined([shell, feet])
