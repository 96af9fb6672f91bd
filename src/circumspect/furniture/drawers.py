"""Fronts of drawers with their handles."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import handle
from circumspect.furniture.placement import joined
from circumspect.furniture.primitives import box
from circumspect.geometry import TriangleMesh


def drawer_fronts(
    rng: np.random.Generator,
    size: tuple[float, float],
    front: float,
    grid: tuple[int, int],
    handles: bool = True,
) -> TriangleMesh:
    """Rows and columns of drawers on a face that looks to -y.

    Args:
        rng: Draws gaps, thickness, handles and heights of rows.
        size: (width, height) of the face [m]; its lower edge is centred on the origin.
        front: y of the face [m].
        grid: (columns, rows).
        handles: Whether the drawers have any.
    """
    width, height = size
    columns, rows = grid
    gap = rng.uniform(0.006, 0.02)
    proud = rng.uniform(0.008, 0.022)
    style = str(rng.choice(["knob", "bar", "bow"]))
    cell = (width - gap) / columns
    # Lower drawers are often taller.
    growth = rng.choice([1.0, 0.85])
    shares = growth ** np.arange(rows)
    tall = shares / shares.sum() * (height - gap)
    bases = gap + np.concatenate([[0.0], np.cumsum(tall)[:-1]])
    two_knobs = style == "knob" and cell > 0.55
    parts = []
    for column in range(columns):
        x = -width / 2 + gap / 2 + cell * (column + 0.5)
        for base, high in zip(bases, tall, strict=True):
            parts.append(box((cell - gap, proud, high - gap), (x, front - proud / 2, base)))
            if not handles:
                continue
            places = (-0.25 * cell, 0.25 * cell) if two_knobs else (0.0,)
            level = base + 0.5 * (high - gap)
            for shift in places:
                parts.append(handle(rng, style, (x + shift, front - proud, level), 0.3 * cell))
    return joined(parts)
