"""Chairs: a seat, a back, arms, and what carries them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.chair_parts import back_rest, base
from circumspect.furniture.outlines import Outline, ellipse, rounded_rectangle, superellipse
from circumspect.furniture.placement import both_sides, joined, moved, turned
from circumspect.furniture.primitives import rounded_box, slab, tube
from circumspect.furniture.sheets import evenly_spaced, shell, smooth_path
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True)
class Seat:
    """Measures that the other parts of a chair must fit.

    Attributes:
        width, depth: of the seat [m].
        height: of its upper side [m].
        thickness: [m].
        spread: share of width and depth at which legs and posts still meet the seat.
    """

    width: float
    depth: float
    height: float
    thickness: float
    spread: float

    @property
    def under(self) -> float:
        """Height of the seat's underside [m]."""
        return self.height - self.thickness


def chair(rng: np.random.Generator) -> TriangleMesh:
    """A chair with its back to +y."""
    kind = str(rng.choice(["plain", "shell", "armchair", "folding"], p=[0.66, 0.16, 0.12, 0.06]))
    if kind == "shell":
        return _shell_chair(rng)
    if kind == "armchair":
        return _armchair(rng)
    if kind == "folding":
        return _folding_chair(rng)
    form = str(rng.choice(["rounded", "tapered", "round"], p=[0.5, 0.35, 0.15]))
    width = rng.uniform(0.38, 0.6)
    seat = Seat(
        width=width,
        depth=width * rng.uniform(0.88, 1.15),
        height=rng.uniform(0.4, 0.52),
        thickness=rng.uniform(0.02, 0.1),
        spread=0.68 if form == "round" else 0.94,
    )
    outline = _seat_outline(rng, form, seat)
    pad = slab(outline, seat.thickness, (0.0, 0.0, seat.under), 0.45 * seat.thickness)
    parts = [pad, base(rng, seat), back_rest(rng, seat)]
    if rng.random() < 0.4:
        parts.append(_arms(rng, seat))
    return joined(parts)


def _seat_outline(rng: np.random.Generator, form: str, seat: Seat) -> Outline:
    if form == "round":
        return ellipse(seat.width, seat.depth)
    if form == "rounded":
        return rounded_rectangle(seat.width, seat.depth, rng.uniform(0.01, 0.3) * seat.width)
    outline = superellipse(seat.width, seat.depth, rng.uniform(4.0, 10.0))
    narrowing = rng.uniform(0.05, 0.2) * (outline[:, 1] / seat.depth + 0.5)
    return outline * np.stack([1 - narrowing, np.ones(len(outline))], axis=1)


def _arms(rng: np.random.Generator, seat: Seat) -> TriangleMesh:
    """Arm rests on posts, or bent rods from the back to the seat."""
    high = seat.height + rng.uniform(0.17, 0.26)
    x = seat.width / 2 * seat.spread + 0.02
    front, rear = -seat.depth * rng.uniform(0.15, 0.42), seat.depth / 2
    low = seat.height - 0.5 * seat.thickness
    thick = rng.uniform(0.025, 0.045)
    if rng.random() < 0.5:
        long = rear - front + 0.06
        rest = rounded_box(
            (rng.uniform(0.04, 0.08), long, thick),
            (x, (front + rear) / 2, high - thick),
            0.4 * thick,
        )
        post = tube([(x, front + 0.03, low), (x, front + 0.03, high - 0.5 * thick)], thick, 4)
        return both_sides(joined([rest, post]))
    corners = [(x, rear, high), (x, front, high), (x, front + rng.uniform(0.0, 0.1), low)]
    if rng.random() < 0.5:
        corners.append((x, rear - 0.1, low))
    return both_sides(tube(smooth_path(corners, 0.12), thick))


def _shell_chair(rng: np.random.Generator) -> TriangleMesh:
    """A seat and back moulded in one sheet."""
    width = rng.uniform(0.44, 0.68)
    depth = width * rng.uniform(0.85, 1.1)
    height = rng.uniform(0.38, 0.46)
    tall = rng.uniform(0.3, 0.55)
    lean = rng.uniform(0.08, 0.25)
    seat = Seat(width, depth, height, 0.02, 0.62)
    dip = rng.uniform(0.0, 0.04)
    corners = np.array(
        [
            (0.0, -depth / 2 - 0.01, height - 0.03),
            (0.0, -depth / 2 + 0.05, height),
            (0.0, depth / 2 - 0.06, height - dip),
            (0.0, depth / 2 - 0.06 + lean, height + tall),
        ]
    )
    profile = evenly_spaced(smooth_path(corners, rng.uniform(0.12, 0.25), 6), 18)[:, 1:]
    shares = np.linspace(0.0, 1.0, len(profile))
    rounding = rng.uniform(0.05, 0.5) * np.abs(2 * shares - 1) ** rng.uniform(3.0, 6.0)
    # The sides rise most where the seat turns into the back.
    curls = rng.uniform(0.02, 0.16) * np.exp(-(((shares - 0.6) / 0.3) ** 2))
    body = shell(profile, width * (1 - rounding), curls, rng.uniform(0.01, 0.03))
    return joined([body, base(rng, seat)])


def _armchair(rng: np.random.Generator) -> TriangleMesh:
    """An upholstered easy chair: blocks for arms, seat and back."""
    width = rng.uniform(0.6, 0.85)
    depth = rng.uniform(0.6, 0.85)
    lift = rng.choice([0.0, rng.uniform(0.06, 0.2)])
    seat_high = rng.uniform(0.36, 0.45)
    arm = rng.uniform(0.07, 0.16)
    back = rng.uniform(0.1, 0.2)
    tall = rng.uniform(0.72, 1.05)
    soft = rng.uniform(0.015, 0.045)
    inner = width - 2 * arm
    lean = rng.uniform(0.0, 0.2)
    rest = rounded_box((inner, back, tall - lift), (0.0, (depth - back) / 2, lift), soft)
    high = rng.uniform(0.5, 0.64)
    block = rounded_box((arm, depth, high - lift), ((width - arm) / 2, 0.0, lift), soft)
    parts = [
        rounded_box((inner, depth - 0.02, seat_high - lift), (0.0, 0.0, lift), soft),
        turned(rest, -lean, "x", (0.0, depth / 2 - back, seat_high)),
        both_sides(block),
    ]
    if lift > 0:
        parts.append(base(rng, Seat(width, depth, lift + 0.01, 0.01, 0.9), kind="legs"))
    return joined(parts)


def _folding_chair(rng: np.random.Generator) -> TriangleMesh:
    """Two frames crossed like an X, a seat and a band at the back."""
    width = rng.uniform(0.4, 0.48)
    depth = rng.uniform(0.4, 0.5)
    height = rng.uniform(0.42, 0.47)
    tall = rng.uniform(0.78, 0.9)
    thick = rng.uniform(0.02, 0.035)
    x = width / 2
    half = thick / 2
    front = tube([(x, -depth / 2, half), (x, depth * 0.62, tall)], thick, 4)
    rear = tube([(x - thick, depth / 2, half), (x - thick, -depth * 0.4, height)], thick, 4)
    rungs = [
        tube([(-x, y, z), (x, y, z)], thick * 0.8, 4)
        for y, z in ((-depth * 0.44, 0.08), (depth * 0.42, 0.1))
    ]
    pad = rounded_box((width - 2 * thick, depth * 0.85, 0.025), (0.0, 0.0, height - 0.01), 0.008)
    band_high = rng.uniform(0.1, 0.3)
    band = rounded_box((width, 0.02, band_high), (0.0, 0.0, -band_high), 0.008)
    slope = np.arctan2(depth * 1.12, tall)
    band = moved(turned(band, -slope, "x"), (0.0, depth * 0.62, tall))
    return joined([both_sides(front), both_sides(rear), *rungs, pad, band])
