"""Tables: a top and what carries it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.legs import four_legs, star_base
from circumspect.furniture.outlines import (
    Outline,
    ellipse,
    rectangle,
    rounded_rectangle,
    superellipse,
)
from circumspect.furniture.placement import around, both_sides, joined, moved
from circumspect.furniture.primitives import box, cylinder, revolved, slab, strip, tube
from circumspect.furniture.sheets import smooth_path
from circumspect.geometry import TriangleMesh

_KINDS = ("legs", "pedestal", "trestle", "panels", "frames", "box")
_SHARES_ROUND = (0.5, 0.44, 0.0, 0.0, 0.0, 0.06)
_SHARES_STRAIGHT = (0.62, 0.09, 0.08, 0.08, 0.09, 0.04)


@dataclass(frozen=True)
class _Use:
    """Uses of tables, which determine their sizes; ranges in metres.

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


def support(
    rng: np.random.Generator, is_round: bool, width: float, depth: float, under: float
) -> TriangleMesh:
    """Everything that carries a top.

    Args:
        rng: Draws the kind and its details.
        is_round: Whether the top is an ellipse or a rectangle.
        width: Of the top [m].
        depth: Of the top [m].
        under: Height of its underside [m].
    """
    kind = str(rng.choice(_KINDS, p=_SHARES_ROUND if is_round else _SHARES_STRAIGHT))
    if kind == "pedestal":
        return _pedestals(rng, width, depth, under)
    if kind == "trestle":
        return _trestles(rng, width, depth, under)
    if kind == "panels":
        return _panels(rng, width, depth, under)
    if kind == "frames":
        return _frames(rng, width, depth, under)
    if kind == "box":
        share = rng.uniform(0.5, 0.85)
        outline = ellipse if is_round else rectangle
        return slab(outline(width * share, depth * share), under, (0.0, 0.0, 0.0), 0.005)
    return _legs(rng, is_round, width, depth, under)


def _legs(
    rng: np.random.Generator, is_round: bool, width: float, depth: float, under: float
) -> TriangleMesh:
    """Three or four legs with aprons, a shelf or stretchers."""
    thick = float(np.clip(rng.uniform(0.025, 0.075) * np.sqrt(under + width), 0.02, 0.12))
    if is_round and rng.random() < 0.3:
        return _tripod(rng, depth, under, thick)
    # Legs of a round top stand on its inscribed rectangle.
    inset = 0.66 if is_round else float(rng.choice([rng.uniform(0.7, 0.9), rng.uniform(0.9, 1.0)]))
    span = (width * inset - thick, depth * inset - thick)
    parts = [four_legs(rng, span, under, thick)]
    if rng.random() < 0.6:
        parts.append(_aprons(rng, span, under, thick))
    shelf = rng.random()
    if shelf < 0.26:
        level = rng.uniform(0.1, 0.5) * under
        size = (span[0] + 0.8 * thick, span[1] + 0.8 * thick)
        outline = ellipse(*size) if is_round else rectangle(*size)
        parts.append(slab(outline, rng.uniform(0.012, 0.035), (0.0, 0.0, level), 0.002))
    elif shelf < 0.42:
        parts.append(_stretchers(rng, span, rng.uniform(0.08, 0.35) * under, 0.6 * thick))
    return joined(parts)


def _tripod(rng: np.random.Generator, depth: float, under: float, thick: float) -> TriangleMesh:
    """Three legs that lean outwards or inwards."""
    foot, top = depth * rng.uniform(0.3, 0.45), depth * rng.uniform(0.12, 0.4)
    half = 0.35 * thick
    rod = tube([(foot, 0.0, half), (top, 0.0, under)], [0.7 * thick, thick], 8)
    return around(rod, 3, np.pi / 2)


def _aprons(
    rng: np.random.Generator, span: tuple[float, float], under: float, thick: float
) -> TriangleMesh:
    """Rails between the legs below the top, their lower edges straight or arched."""
    deep = rng.uniform(0.06, 0.22) * under
    rail = min(0.025, 0.6 * thick)
    arch = float(rng.choice([0.0, rng.uniform(0.3, 0.7)], p=[0.7, 0.3])) * deep
    parts = []
    for axis, long, place in (("y", span[0], span[1] / 2), ("x", span[1], span[0] / 2)):
        u = np.linspace(-long / 2, long / 2, 11 if arch > 0 else 2)
        low = under - deep + arch * (1 - (2 * u / long) ** 2)
        board = strip(u, low, under, place - rail / 2, place + rail / 2, axis)
        parts.append(both_sides(board, axis))
    return joined(parts)


def _stretchers(
    rng: np.random.Generator, span: tuple[float, float], level: float, thick: float
) -> TriangleMesh:
    """Rods low between the legs: an H, a cross or a frame."""
    x, y = span[0] / 2, span[1] / 2
    kind = str(rng.choice(["H", "cross", "frame"]))
    if kind == "cross":
        rod = tube([(-x, -y, level), (x, y, level)], thick, 4)
        return both_sides(rod)
    side = both_sides(tube([(x, -y, level), (x, y, level)], thick, 4))
    if kind == "H":
        return joined([side, tube([(-x, 0.0, level), (x, 0.0, level)], thick, 4)])
    return joined([side, both_sides(tube([(-x, y, level), (x, y, level)], thick, 4), "y")])


def _pedestals(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """One column under a short top, two under a long one."""
    reach = rng.uniform(0.24, 0.42) * depth
    foot = str(rng.choice(["disc", "star", "cone", "turned"], p=[0.35, 0.3, 0.2, 0.15]))
    column = rng.uniform(0.05, 0.16) * min(1.0, depth + 0.2)
    levels = np.linspace(0.0, 1.0, 13)
    if foot == "disc":
        one = joined([cylinder(2 * reach, rng.uniform(0.012, 0.05)), cylinder(column, under)])
    elif foot == "cone":
        waist = rng.uniform(0.1, 0.35)
        radii = reach * (waist + (1 - waist) * np.abs(1 - 2 * levels) ** rng.uniform(1.5, 4.0))
        one = revolved(np.stack([radii, levels * under], axis=1), corners=24)
    else:
        arms = int(rng.integers(3, 6))
        star = star_base(rng, arms, reach, rng.uniform(0.08, 0.25) * under, wheels=False)
        swell = rng.uniform(0.0, 0.5) if foot == "turned" else 0.0
        radii = column / 2 * (1 + swell * np.sin(levels * rng.uniform(8.0, 16.0)))
        low = 0.06 * under
        shaft = np.stack([radii, low + levels * (under - low)], axis=1)
        one = joined([star, revolved(shaft)])
    if width < 1.6 * depth:
        return one
    return both_sides(moved(one, (rng.uniform(0.22, 0.32) * width, 0.0, 0.0)))


def _trestles(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two A-, X- or T-shaped stands joined by a beam."""
    x = width / 2 * rng.uniform(0.6, 0.88)
    y = depth / 2 * rng.uniform(0.7, 0.9)
    thick = rng.uniform(0.05, 0.1)
    form = str(rng.choice(["A", "X", "T"]))
    if form == "T":
        foot = (thick, 2 * y, thick)
        stand = joined(
            [
                box(foot, (x, 0.0, 0.0)),
                box((thick, 2 * thick, under), (x, 0.0, 0.0)),
                box(foot, (x, 0.0, under - thick)),
            ]
        )
    else:
        top = 0.25 * y if form == "A" else -y
        half = thick / 2
        stand = both_sides(tube([(x, y, half), (x, top, under - half)], thick, 4), "y")
    beam = box((2 * x, 0.5 * thick, thick), (0.0, 0.0, rng.uniform(0.3, 0.6) * under))
    return joined([both_sides(stand), beam])


def _panels(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two upright boards, perhaps with shelves between them."""
    thick = rng.uniform(0.02, 0.09)
    x = width / 2 * rng.uniform(0.75, 1.0) - thick / 2
    deep = depth * rng.uniform(0.7, 1.0)
    parts = [both_sides(box((thick, deep, under), (x, 0.0, 0.0)))]
    if rng.random() < 0.5:
        level = rng.uniform(0.1, 0.5) * under
        parts.append(box((2 * x, deep * 0.95, 0.02), (0.0, 0.0, level)))
    if rng.random() < 0.3:
        parts.append(box((2 * x, deep * 0.95, 0.03)))
    return joined(parts)


def _frames(rng: np.random.Generator, width: float, depth: float, under: float) -> TriangleMesh:
    """Two bent frames: loops at both ends, or an X of bars under each end."""
    thick = rng.uniform(0.02, 0.06)
    x = width / 2 * rng.uniform(0.7, 0.98) - thick / 2
    y = depth / 2 * rng.uniform(0.8, 1.0) - thick / 2
    half = thick / 2
    if rng.random() < 0.3:
        bar = tube([(x, -y, half), (x, y, under - half)], thick, 4)
        return both_sides(both_sides(bar, "y"))
    bend = float(rng.choice([0.01, 0.15]))
    corners = [(x, 0.0, half), (x, y, half), (x, y, under - half), (x, 0.0, under - half)]
    loop = both_sides(tube(smooth_path(corners, bend), thick, 4), "y")
    parts = [both_sides(loop)]
    if rng.random() < 0.4:
        parts.append(both_sides(tube([(-x, y, half), (x, y, half)], thick, 4), "y"))
    return joined(parts)
