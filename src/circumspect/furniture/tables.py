"""Tables: a top on four legs, a pedestal, trestles or two panels."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import four_legs, star_base
from circumspect.furniture.outlines import Outline, ellipse, rectangle, rounded_rectangle
from circumspect.furniture.placement import both_sides, joined
from circumspect.furniture.primitives import box, cylinder, prism, revolved, slab, tube
from circumspect.geometry import TriangleMesh


def table(rng: np.random.Generator) -> TriangleMesh:
    """A table, 0.3 to 1.1 m high, its long side along x."""
    use = str(rng.choice(["coffee", "dining", "side", "bar"], p=[0.38, 0.4, 0.14, 0.08]))
    low, high = {
        "coffee": (0.32, 0.5),
        "dining": (0.7, 0.78),
        "side": (0.45, 0.65),
        "bar": (0.9, 1.1),
    }[use]
    height = rng.uniform(low, high)
    narrow, wide = {
        "coffee": (0.7, 1.4),
        "dining": (0.8, 2.2),
        "side": (0.4, 0.7),
        "bar": (0.5, 0.9),
    }[use]
    width = rng.uniform(narrow, wide)
    shape = str(rng.choice(["rectangle", "square", "round", "oval"], p=[0.52, 0.14, 0.24, 0.1]))
    if shape in ("round", "square"):
        width = min(width, 1.5)
    depth = width if shape in ("round", "square") else width * rng.uniform(0.36, 0.8)
    thickness = rng.uniform(0.015, 0.06)
    under = height - thickness
    edge = rng.uniform(0.0, 0.012)
    top = slab(_outline(rng, shape, width, depth), thickness, (0.0, 0.0, under), edge + 0.001)
    return joined([top, _support(rng, shape, width, depth, under)])


def _outline(rng: np.random.Generator, shape: str, width: float, depth: float) -> Outline:
    if shape in ("round", "oval"):
        return ellipse(width, depth, 36)
    if rng.random() < 0.5:
        return rectangle(width, depth)
    return rounded_rectangle(width, depth, rng.uniform(0.02, 0.3) * depth)


def _support(
    rng: np.random.Generator, shape: str, width: float, depth: float, under: float
) -> TriangleMesh:
    """All that carries the top, whose underside is at the height `under`."""
    shares = [0.4, 0.6, 0.0, 0.0] if shape in ("round", "oval") else [0.68, 0.08, 0.1, 0.14]
    kind = str(rng.choice(["legs", "pedestal", "trestle", "panels"], p=shares))
    if kind == "pedestal":
        return _pedestals(rng, width, depth, under)
    if kind == "trestle":
        return _trestles(rng, width, depth, under)
    if kind == "panels":
        return _panels(rng, width, depth, under)
    # Legs of a round top stand on its inscribed rectangle.
    inset = 0.66 if shape in ("round", "oval") else rng.uniform(0.86, 0.97)
    thick = float(np.clip(rng.uniform(0.03, 0.07) * np.sqrt(under + width), 0.025, 0.12))
    span = (width * inset - thick, depth * inset - thick)
    parts = [four_legs(rng, span, under, thick)]
    if rng.random() < 0.6:
        parts.append(_aprons(rng, span, under, thick))
    if rng.random() < 0.3:
        level = rng.uniform(0.12, 0.45) * under
        parts.append(box((span[0] + thick, span[1] + thick, 0.02), (0.0, 0.0, level)))
    elif rng.random() < 0.15:
        parts.append(_stretchers(span, rng.uniform(0.1, 0.3) * under, 0.6 * thick))
    return joined(parts)


def _aprons(
    rng: np.random.Generator, span: tuple[float, float], under: float, thick: float
) -> TriangleMesh:
    """Rails between the legs below the top."""
    deep = rng.uniform(0.06, 0.2) * under
    rail = min(0.025, 0.6 * thick)
    base = under - deep
    long = both_sides(box((span[0], rail, deep), (0.0, span[1] / 2, base)), "y")
    short = both_sides(box((rail, span[1], deep), (span[0] / 2, 0.0, base)), "x")
    return joined([long, short])


def _stretchers(span: tuple[float, float], level: float, thick: float) -> TriangleMesh:
    """An H of rods low between the legs."""
    x, y = span[0] / 2, span[1] / 2
    side = both_sides(tube([(x, -y, level), (x, y, level)], thick, 4))
    return joined([side, tube([(-x, 0.0, level), (x, 0.0, level)], thick, 4)])


def _pedestals(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """One column under a short top, two under a long one."""
    count = 2 if width > 1.6 * depth else 1
    reach = rng.uniform(0.28, 0.42) * depth
    foot = str(rng.choice(["disc", "star", "cone"]))
    column = rng.uniform(0.05, 0.14) * min(1.0, depth + 0.2)
    if foot == "disc":
        plate = rng.uniform(0.015, 0.04)
        one = joined([cylinder(2 * reach, plate), cylinder(column, under)])
    elif foot == "star":
        arms = int(rng.integers(3, 6))
        star = star_base(rng, arms, reach, rng.uniform(0.08, 0.2) * under, wheels=False)
        one = joined([star, cylinder(column, under)])
    else:
        levels = np.linspace(0.0, 1.0, 9)
        waist = rng.uniform(0.1, 0.35)
        radii = reach * (waist + (1 - waist) * np.abs(1 - 2 * levels) ** rng.uniform(1.5, 4.0))
        one = revolved(np.stack([radii, levels * under], axis=1), corners=24)
    if count == 1:
        return one
    shift = np.array([0.28 * width, 0.0, 0.0])
    return both_sides(TriangleMesh(one.vertices_xyz + shift, one.faces))


def _trestles(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two A- or X-shaped or T-shaped stands joined by a beam."""
    x = width / 2 * rng.uniform(0.65, 0.88)
    y = depth / 2 * rng.uniform(0.7, 0.9)
    thick = rng.uniform(0.05, 0.09)
    form = str(rng.choice(["A", "X", "T"]))
    if form == "T":
        stand = joined(
            [
                box((thick, 2 * y, thick), (x, 0.0, 0.0)),
                box((thick, 2 * thick, under), (x, 0.0, 0.0)),
                box((thick, 2 * y, thick), (x, 0.0, under - thick)),
            ]
        )
    else:
        top = 0.25 * y if form == "A" else -y
        half = thick / 2
        rod = tube([(x, y, half), (x, top, under - half)], thick, 4)
        stand = both_sides(rod, "y")
    level = rng.uniform(0.3, 0.6) * under
    beam = box((2 * x, 0.5 * thick, thick), (0.0, 0.0, level))
    return joined([both_sides(stand), beam])


def _panels(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two upright boards, perhaps with a shelf between them."""
    thick = rng.uniform(0.02, 0.08)
    x = width / 2 * rng.uniform(0.75, 1.0) - thick / 2
    board = box((thick, depth * rng.uniform(0.7, 1.0), under), (x, 0.0, 0.0))
    parts = [both_sides(board)]
    if rng.random() < 0.5:
        level = rng.uniform(0.1, 0.5) * under
        parts.append(box((2 * x, depth * 0.7, 0.02), (0.0, 0.0, level)))
    if rng.random() < 0.3:
        plinth = prism(rectangle(2 * x, depth * 0.7), 0.03)
        parts.append(plinth)
    return joined(parts)
