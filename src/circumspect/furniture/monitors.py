"""Monitors: a flat panel on a stand, a screen with a hump behind it, or a tube in its case."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.outlines import ellipse, rectangle, rounded_rectangle
from circumspect.furniture.placement import both_sides, joined, moved, turned
from circumspect.furniture.primitives import box, cylinder, rounded_box, slab, stacked, tube
from circumspect.furniture.sheets import smooth_path
from circumspect.geometry import TriangleMesh


def monitor(rng: np.random.Generator) -> TriangleMesh:
    """A computer screen or television that looks to -y, 0.3 to 1.2 m wide."""
    kind = str(rng.choice(["flat", "tube", "television"], p=[0.68, 0.22, 0.1]))
    if kind == "tube":
        return _tube_monitor(rng)
    width = rng.uniform(0.36, 0.7) if kind == "flat" else rng.uniform(0.7, 1.2)
    tall = width * float(rng.choice([9 / 16, 10 / 16, 3 / 4, 4 / 5], p=[0.4, 0.25, 0.2, 0.15]))
    thick = width * rng.uniform(0.03, 0.13)
    lift = width * rng.uniform(0.03, 0.32)
    if rng.random() < 0.07:
        # A screen for the wall has no stand; it rests on its lower edge here.
        return _panel(rng, width, tall, thick)
    panel = moved(_panel(rng, width, tall, thick), (0.0, 0.0, lift))
    middle = lift + tall * rng.uniform(0.3, 0.55)
    tilt = float(rng.choice([0.0, rng.uniform(0.0, 0.2)]))
    parts = [
        turned(panel, -tilt, "x", (0.0, 0.0, middle)),
        _stand(rng, width, thick, lift, middle),
    ]
    if rng.random() < 0.1:
        speaker = box((0.12 * width, thick, 0.9 * tall), (0.57 * width, 0.0, lift + 0.05 * tall))
        parts.append(both_sides(speaker))
    return joined(parts)


def _panel(rng: np.random.Generator, width: float, tall: float, thick: float) -> TriangleMesh:
    """The screen with its bezel and what bulges behind it, standing on z = 0, y around 0."""
    bezel = width * rng.uniform(0.02, 0.07)
    chin = bezel * float(rng.choice([1.0, rng.uniform(1.2, 3.0)]))
    lip = 0.006
    outline = rounded_rectangle(width, tall, width * rng.uniform(0.002, 0.05), 3)
    case = turned(slab(outline, thick, (0.0, 0.0, 0.0), 0.15 * thick), np.pi / 2, "x")
    front = -thick / 2
    parts = [moved(case, (0.0, thick / 2, tall / 2))]
    if rng.random() < 0.7:
        side = box((bezel, lip, tall), ((width - bezel) / 2, front, 0.0))
        parts.append(both_sides(side))
        parts.append(box((width, lip, chin), (0.0, front, 0.0)))
        parts.append(box((width, lip, bezel), (0.0, front, tall - bezel)))
    if rng.random() < 0.6:
        parts.append(_hump(rng, width, tall, thick))
    return joined(parts)


def _hump(rng: np.random.Generator, width: float, tall: float, thick: float) -> TriangleMesh:
    """The electronics behind a panel: a block whose sides slope."""
    low = rng.uniform(0.55, 0.95)
    high = low * rng.uniform(0.5, 1.0)
    deep = width * rng.uniform(0.03, 0.14)
    base = rectangle(width, tall)
    block = turned(stacked([base * low, base * high], [0.0, deep]), -np.pi / 2, "x")
    return moved(block, (0.0, thick / 2 - 0.004, tall / 2))


def _stand(
    rng: np.random.Generator, width: float, thick: float, lift: float, middle: float
) -> TriangleMesh:
    """A foot on the desk and a neck to the panel."""
    reach = width * rng.uniform(0.32, 0.65)
    plate = rng.uniform(0.008, 0.025)
    deep = min(reach, width * rng.uniform(0.25, 0.48))
    kind = str(
        rng.choice(["disc", "plate", "two feet", "bent", "wedge"], p=[0.3, 0.34, 0.12, 0.12, 0.12])
    )
    back = thick / 2 + rng.uniform(0.012, 0.05)
    if kind == "bent":
        return _bent_plate(reach, deep, back, middle)
    if kind == "two feet":
        half = 0.33 * width
        foot = box((0.03, deep, plate), (half, 0.0, 0.0))
        post = box((0.02, 0.02, lift + 0.05), (half, 0.0, 0.0))
        return both_sides(joined([foot, post]))
    if kind == "wedge":
        shares = np.array([1.0, 0.92, rng.uniform(0.25, 0.5), rng.uniform(0.2, 0.4)])
        levels = np.array([0.0, 0.12, 0.7, 1.0]) * max(lift - 0.01, 0.02)
        hill = stacked(ellipse(reach, deep)[None] * shares[:, None, None], levels)
        return joined([hill, _neck(rng, width, back, middle)])
    if kind == "disc":
        foot = slab(ellipse(reach, deep), plate, (0.0, 0.0, 0.0), 0.3 * plate)
    else:
        foot = slab(rounded_rectangle(reach, deep, 0.02), plate, (0.0, 0.0, 0.0), 0.3 * plate)
    return joined([foot, _neck(rng, width, back, middle)])


def _neck(rng: np.random.Generator, width: float, back: float, middle: float) -> TriangleMesh:
    """An upright behind the panel and a short arm to it; flat, round or leaning."""
    wide = width * rng.uniform(0.05, 0.22)
    arm = box((wide * 0.8, back + 0.01, 0.05), (0.0, back / 2, middle - 0.05))
    if rng.random() < 0.4:
        return joined([cylinder(min(wide, 0.07), middle, (0.0, back, 0.0), 16), arm])
    lean = rng.uniform(0.0, 0.05)
    bar = stacked([rectangle(wide, 0.022), rectangle(wide * rng.uniform(0.6, 1.0), 0.022)], [0, 1])
    points = bar.vertices_xyz * (1.0, 1.0, middle)
    points = points + np.stack(
        [np.zeros(len(points)), back + lean * (1 - points[:, 2] / middle), np.zeros(len(points))], 1
    )
    return joined([TriangleMesh(points, bar.faces), arm])


def _bent_plate(reach: float, deep: float, back: float, middle: float) -> TriangleMesh:
    """One strip of metal that lies on the desk and turns up behind the panel."""
    path = [(0.0, -deep * 0.6, 0.005), (0.0, back + 0.03, 0.005), (0.0, back, middle)]
    strip = tube(smooth_path(path, 0.03), 0.01, 4)
    wide = TriangleMesh(strip.vertices_xyz * (50 * reach, 1.0, 1.0), strip.faces)
    return joined([wide, box((0.6 * reach, back + 0.005, 0.03), (0.0, back / 2, middle - 0.035))])


def _tube_monitor(rng: np.random.Generator) -> TriangleMesh:
    """A cathode ray tube: a case that narrows to the back, on a swivel foot or none."""
    width = rng.uniform(0.32, 0.55)
    tall = width * rng.uniform(0.75, 1.0)
    deep = width * rng.uniform(0.55, 1.15)
    narrow = rng.uniform(0.45, 0.85)
    shares = np.array([0.97, 1.0, 1.0, 0.5 + 0.5 * narrow, narrow, narrow * 0.97])
    knee = rng.uniform(0.15, 0.45)
    levels = np.array([0.0, 0.02, knee, knee + 0.15, 0.97, 1.0]) * deep
    outline = rounded_rectangle(width, tall, width * rng.uniform(0.01, 0.06), 3)
    case = turned(stacked(outline[None] * shares[:, None, None], levels), -np.pi / 2, "x")
    lift = float(rng.choice([0.0, rng.uniform(0.02, 0.09)], p=[0.35, 0.65]))
    parts = [moved(case, (0.0, -deep / 2, tall / 2 + lift))]
    rim = width * rng.uniform(0.03, 0.08)
    parts.append(_bezel(width, tall, rim, -deep / 2, lift))
    if lift > 0:
        place = (0.0, -0.1 * deep, 0.0)
        if rng.random() < 0.6:
            parts.append(cylinder(width * rng.uniform(0.5, 0.75), lift + 0.02, place))
        else:
            size = (width * 0.7, deep * 0.6, lift + 0.02)
            parts.append(rounded_box(size, place, 0.01))
    return joined(parts)


def _bezel(width: float, tall: float, rim: float, front: float, lift: float) -> TriangleMesh:
    """A frame before the glass."""
    lip = 0.014
    y = front - lip / 2 + 0.004
    side = both_sides(
        box((rim, lip, 0.97 * tall), (0.485 * width - rim / 2, y, lift + 0.015 * tall))
    )
    bars = [
        box((0.97 * width, lip, rim), (0.0, y, lift + z))
        for z in (0.015 * tall, 0.985 * tall - rim)
    ]
    return joined([side, *bars])
