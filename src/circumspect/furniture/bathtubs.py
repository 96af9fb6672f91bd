"""Bathtubs: a shell with a basin, standing free, on claw feet, or built in with an apron."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.legs import cabriole_leg
from circumspect.furniture.outlines import (
    Outline,
    refined,
    resampled,
    rounded_polygon,
    rounded_rectangle,
    superellipse,
)
from circumspect.furniture.placement import four_corners, joined
from circumspect.furniture.primitives import box, leg, stacked, tube
from circumspect.furniture.sheets import smooth_path
from circumspect.geometry import TriangleMesh

_CORNERS = 40


def bathtub(rng: np.random.Generator) -> TriangleMesh:
    """A bathtub along x, 1.1 to 1.9 m long."""
    kind = str(rng.choice(["free", "built in", "corner", "round"], p=[0.42, 0.42, 0.1, 0.06]))
    if kind == "built in":
        return _built_in(rng)
    if kind == "corner":
        return _corner(rng)
    return _free(rng, is_round=kind == "round")


def _free(rng: np.random.Generator, is_round: bool) -> TriangleMesh:
    """A tub that stands free: it narrows to its foot, its rim may rise at the ends."""
    length = rng.uniform(1.4, 1.9) if not is_round else rng.uniform(1.1, 1.5)
    width = length * rng.uniform(0.4, 0.54) if not is_round else length * rng.uniform(0.85, 1.0)
    height = rng.uniform(0.44, 0.68)
    lift = float(rng.choice([0.0, rng.uniform(0.07, 0.18)]))
    foot = rng.uniform(0.6, 0.95)
    rim = rng.uniform(0.02, 0.06)
    belly = rng.uniform(0.0, 0.06)
    tall = height - lift
    if is_round or rng.random() < 0.5:
        outer = superellipse(length, width, rng.uniform(2.0, 3.5), _CORNERS)
    else:
        outer = rounded_rectangle(length, width, width * rng.uniform(0.25, 0.5), 9)
    levels = np.array([0.0, 0.3, 0.65, 0.93, 0.95, 1.0, 1.0, 0.9, 0.5, 0.18, 0.12])
    outside = np.interp(levels[:4], [0.0, 1.0], [foot, 0.97]) + belly * np.sin(np.pi * levels[:4])
    inner = 1 - 2 * rim / width
    basin = np.array([1.0, 0.97, 0.5 + 0.5 * foot, 0.95 * foot, 0.8 * foot]) * inner
    shares = np.concatenate([outside, [1.0, 1.0], basin])
    tub = stacked(outer[None] * shares[:, None, None], levels * tall, (0.0, 0.0, lift))
    rise = rng.choice([0.0, rng.uniform(0.1, 0.4)], p=[0.6, 0.4]) * (0.44 / height)
    tub = _slipper(tub, length, lift, rise, both_ends=rng.random() < 0.5)
    parts = [tub]
    if lift > 0:
        span = (length * foot * 0.62, width * foot * 0.6)
        parts.append(_feet(rng, span, lift + 0.02))
    if rng.random() < 0.35:
        place = (0.0, 0.49 * width) if rise > 0 or rng.random() < 0.5 else (0.49 * length, 0.0)
        parts.append(_tap(rng, place, height))
    return joined(parts)


def _slipper(
    tub: TriangleMesh, length: float, lift: float, rise: float, both_ends: bool
) -> TriangleMesh:
    """The tub with its rim drawn up at one end or at both."""
    points = tub.vertices_xyz.copy()
    along = points[:, 0] / (length / 2)
    along = np.abs(along) if both_ends else np.maximum(along, 0.0)
    points[:, 2] = lift + (points[:, 2] - lift) * (1 + rise * along**2)
    return TriangleMesh(points, tub.faces)


def _feet(rng: np.random.Generator, span: tuple[float, float], tall: float) -> TriangleMesh:
    """Claws or blocks under the four quarters."""
    thick = rng.uniform(0.05, 0.09)
    place = (span[0] / 2, span[1] / 2, 0.0)
    if rng.random() < 0.6:
        return four_corners(cabriole_leg(rng, place, tall, thick))
    top = (place[0], place[1], tall)
    return four_corners(leg(place, top, thick, thick * rng.uniform(0.8, 1.4)))


def _built_in(rng: np.random.Generator) -> TriangleMesh:
    """A box with a basin sunk into it."""
    length = rng.uniform(1.4, 1.9)
    width = length * rng.uniform(0.42, 0.62)
    height = rng.uniform(0.38, 0.62)
    rim = rng.uniform(0.04, 0.1)
    outer = rounded_rectangle(length, width, rng.uniform(0.005, 0.08), 9)
    inner = (length - 2 * rim, width - 2 * rim)
    kind = str(rng.choice(["stadium", "soft", "ellipse"], p=[0.4, 0.4, 0.2]))
    if kind == "ellipse":
        outer = refined(outer, 0.08)
        towards = outer / (length, width)
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        basin = towards * inner * 0.5
    else:
        share = rng.uniform(0.35, 0.5) if kind == "stadium" else rng.uniform(0.08, 0.3)
        basin = rounded_rectangle(*inner, share * inner[1], 9)
    tub = _sunk(rng, outer, basin, height)
    if rng.random() < 0.25:
        tub = joined([tub, _tap(rng, (length * 0.42, 0.0), height)])
    return tub


def _sunk(rng: np.random.Generator, outer: Outline, basin: Outline, height: float) -> TriangleMesh:
    """A block of the outer outline whose top falls into the basin."""
    deep = rng.uniform(0.06, 0.2) * height
    floor = rng.uniform(0.6, 0.9)
    lip = rng.uniform(0.0, 0.02)
    apron = float(rng.choice([1.0, 1 - rng.uniform(0.02, 0.08)], p=[0.55, 0.45]))
    rings = [outer * apron, outer * apron, outer, outer, basin, basin * 0.97]
    levels = [0.0, height - 0.05, height - 0.045, height, height - lip, 0.85 * height]
    rings += [basin * (floor + 0.06), basin * floor]
    levels += [deep + 0.06, deep]
    return stacked(rings, levels)


def _corner(rng: np.random.Generator) -> TriangleMesh:
    """A tub for a corner of the room: a square with one corner cut off or rounded."""
    side = rng.uniform(1.2, 1.6)
    height = rng.uniform(0.42, 0.6)
    half, cut = side / 2, side * rng.uniform(0.35, 0.6)
    corners = [
        (half, half),
        (-half, half),
        (-half, -half + cut),
        (-half + cut, -half),
        (half, -half),
    ]
    outline = resampled(rounded_polygon(corners, rng.uniform(0.03, 0.3)), _CORNERS)
    middle = outline.mean(axis=0)
    basin = (outline - middle) * rng.uniform(0.78, 0.9) + middle
    return _sunk(rng, outline - middle, basin - middle, height)


def _tap(rng: np.random.Generator, place: tuple[float, float], height: float) -> TriangleMesh:
    """A tap that rises beside the rim and bends over the basin."""
    x, y = place
    tall = rng.uniform(0.06, 0.2)
    reach = rng.uniform(0.08, 0.16)
    inward = np.array([-x, -y]) / (np.hypot(x, y) + 1e-9) * reach
    corners = [
        (x, y, height - 0.03),
        (x, y, height + tall),
        (x + inward[0], y + inward[1], height + tall),
        (x + inward[0], y + inward[1], height + tall - 0.04),
    ]
    spout = tube(smooth_path(corners, 0.05), 0.03)
    grip = box((0.03, 0.16, 0.03), (x, y, height + 0.02))
    return joined([spout, grip])
