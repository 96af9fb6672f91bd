"""Legs, feet and handles that several categories share."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from circumspect.furniture.placement import around, four_corners, joined
from circumspect.furniture.primitives import box, cylinder, leg, revolved, tube
from circumspect.geometry import TriangleMesh


def four_legs(
    rng: np.random.Generator,
    span: tuple[float, float],
    height: float,
    width: float,
    style: str | None = None,
) -> TriangleMesh:
    """Four legs of one style under a rectangle.

    Args:
        rng: Draws the style and its details.
        span: (x, y) distances between the middles of the legs at their tops [m].
        height: [m].
        width: Of a leg at its top [m].
        style: "square", "round", "tapered", "splayed", "turned" or "curved"; None draws one.
    """
    styles = ["square", "round", "tapered", "splayed", "turned", "curved"]
    style = style or str(rng.choice(styles, p=[0.34, 0.14, 0.2, 0.14, 0.1, 0.08]))
    x, y = span[0] / 2, span[1] / 2
    foot, top = (x, y, 0.0), (x, y, height)
    if style == "square":
        one = leg(foot, top, width, width)
    elif style == "round":
        one = leg(foot, top, width, width, sides=12)
    elif style == "tapered":
        one = leg(foot, top, width * rng.uniform(0.4, 0.7), width, int(rng.choice([4, 12])))
    elif style == "splayed":
        out = height * rng.uniform(0.06, 0.2)
        side = out * rng.uniform(0.2, 1.0)
        sides = int(rng.choice([4, 12]))
        one = leg((x + side, y + out, 0.0), top, width * rng.uniform(0.5, 0.8), width, sides)
    elif style == "turned":
        one = turned_leg(rng, foot, height, width)
    else:
        one = cabriole_leg(rng, foot, height, width)
    return four_corners(one)


def turned_leg(
    rng: np.random.Generator, foot: ArrayLike, height: float, width: float
) -> TriangleMesh:
    """A leg from the lathe: beads and necks between a square block and a round foot."""
    levels = np.linspace(0.0, 0.8, 13)
    beads = 0.5 + 0.5 * np.cos(levels * rng.uniform(14.0, 26.0) + rng.uniform(0.0, 6.0))
    radii = width / 2 * (0.58 + 0.42 * beads * rng.uniform(0.6, 1.0))
    shaft = revolved(np.stack([radii, levels * height], axis=1), foot, corners=10)
    top = np.add(foot, (0.0, 0.0, 0.78 * height))
    return joined([shaft, box((width, width, 0.22 * height), top)])


def cabriole_leg(
    rng: np.random.Generator, foot: ArrayLike, height: float, width: float
) -> TriangleMesh:
    """An S-shaped leg whose knee bulges outwards along its diagonal."""
    shares = np.linspace(0.0, 1.0, 9)
    bulge = rng.uniform(0.05, 0.1) * height * np.sin(shares * 2 * np.pi * 0.95 + np.pi)
    outward = np.asarray(foot)[:2]
    outward = np.sign(outward) / np.sqrt(2)
    path = np.empty((9, 3))
    path[:, :2] = np.asarray(foot)[:2] + bulge[:, None] * outward
    path[:, 2] = shares * height
    widths = width * np.interp(shares, [0.0, 0.1, 0.2, 0.75, 1.0], [0.9, 0.6, 0.5, 1.15, 1.0])
    return tube(path, widths, sides=8)


def star_base(
    rng: np.random.Generator, arms: int, reach: float, hub_height: float, wheels: bool
) -> TriangleMesh:
    """A star of arms on the floor round a hub, as under office chairs and pedestal tables."""
    lift = 0.055 if wheels else 0.0
    thick = rng.uniform(0.03, 0.05)
    arm = tube(
        [(0.0, 0.0, hub_height), (reach, 0.0, lift + thick * 0.4)], [thick * 1.3, thick * 0.8], 4
    )
    parts = [around(arm, arms, np.pi / 2), cylinder(2.4 * thick, hub_height + thick)]
    if wheels:
        wheel = tube([(reach, -0.015, 0.03), (reach, 0.015, 0.03)], 0.06, 10)
        parts.append(around(wheel, arms, np.pi / 2))
    return joined(parts)


def handle(rng: np.random.Generator, style: str, middle: ArrayLike, length: float) -> TriangleMesh:
    """A handle in front (-y) of a door or drawer.

    Args:
        rng: Draws small differences.
        style: "knob", "bar" or "bow".
        middle: (3,) [m] on the front face.
        length: [m] of a bar or bow.
    """
    x, y, z = np.asarray(middle, dtype=np.float64)
    out = rng.uniform(0.02, 0.032)
    if style == "knob":
        stem = [(x, y, z), (x, y - 0.5 * out, z), (x, y - 0.6 * out, z), (x, y - out, z)]
        return tube(stem, [0.012, 0.012, 0.03, 0.022], 8)
    half = length / 2
    if style == "bar":
        grip = box((length, 0.012, 0.012), (x, y - out, z - 0.006))
        post = [box((0.01, out, 0.01), (x + s * 0.4 * length, y - out / 2, z)) for s in (-1, 1)]
        return joined([grip, *post])
    shares = np.linspace(0.0, np.pi, 7)
    bow = np.stack([x - half * np.cos(shares), y - out * np.sin(shares), np.full(7, z)], axis=1)
    return tube(bow, 0.012, 6)
