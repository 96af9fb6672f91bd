"""Tables: a top and what carries it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.outlines import (
    Outline,
    ellipse,
    rectangle,
    rounded_rectangle,
    superellipse,
)
from circumspect.furniture.placement import joined
from circumspect.furniture.primitives import slab
from circumspect.furniture.table_supports import support
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True)
class _Use:
    """What a table is for decides its size; ranges in metres.

    Attributes:
        share: of all tables.
        height: of the top.
        width: of the longer side.
    """

    share: float
    height: tuple[float, float]
    width: tuple[float, float]


_USES = (
    _Use(0.42, (0.32, 0.5), (0.75, 1.4)),  # coffee
    _Use(0.46, (0.68, 0.78), (0.85, 2.2)),  # dining
    _Use(0.09, (0.45, 0.65), (0.4, 0.75)),  # side
    _Use(0.03, (0.9, 1.1), (0.5, 1.2)),  # bar
)


def table(rng: np.random.Generator) -> TriangleMesh:
    """A table, 0.3 to 1.1 m high, its long side along x."""
    use = _USES[int(rng.choice(len(_USES), p=[use.share for use in _USES]))]
    height, width = rng.uniform(*use.height), rng.uniform(*use.width)
    shape = str(rng.choice(["rectangle", "square", "round", "oval"], p=[0.6, 0.1, 0.2, 0.1]))
    if shape in ("round", "square"):
        width = min(width, rng.uniform(1.1, 1.6))
    depth = width if shape in ("round", "square") else width * rng.uniform(0.34, 0.75)
    thickness = rng.uniform(0.012, 0.07)
    under = height - thickness
    edge = rng.uniform(0.001, 0.015)
    corner = float(rng.choice([0.0, rng.uniform(0.02, 0.35)], p=[0.6, 0.4]))
    outline = _outline(rng, shape, width, depth, corner)
    top = slab(outline, thickness, (0.0, 0.0, under), edge)
    is_round = shape in ("round", "oval") or corner > 0.15
    return joined([top, support(rng, is_round, width, depth, under)])


def _outline(
    rng: np.random.Generator, shape: str, width: float, depth: float, corner: float
) -> Outline:
    """The top seen from above; `corner` is the radius of a corner over the depth."""
    if shape == "round":
        return ellipse(width, depth, 36)
    if shape == "oval":
        return superellipse(width, depth, rng.uniform(2.0, 3.5), 36)
    if corner == 0.0:
        return rectangle(width, depth)
    return rounded_rectangle(width, depth, corner * depth)
