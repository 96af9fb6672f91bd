"""Dressers and night stands: carcasses on legs, plinths or the floor."""

from __future__ import annotations

import numpy as np

from circumspect.furniture.drawers import (
    DrawerStyle,
    arched_plinth,
    carcass,
    doors,
    fronts,
    open_box,
)
from circumspect.furniture.legs import four_legs
from circumspect.furniture.outlines import ellipse
from circumspect.furniture.placement import joined, moved
from circumspect.furniture.primitives import box, cylinder, slab, strip
from circumspect.geometry import TriangleMesh


def dresser(rng: np.random.Generator) -> TriangleMesh:
    """A chest of drawers, front to -y, 0.5 to 1.8 m wide; the tall ones may have doors."""
    kind = str(rng.choice(["low", "tall", "wardrobe"], p=[0.4, 0.44, 0.16]))
    style = DrawerStyle.drawn(rng)
    if kind == "low":
        width, height = rng.uniform(0.95, 1.6), rng.uniform(0.72, 1.05)
        grid = (int(rng.integers(2, 4)), int(rng.integers(2, 5)))
    elif kind == "tall":
        width, height = rng.uniform(0.55, 1.1), rng.uniform(0.95, 1.45)
        grid = (int(rng.choice([1, 2], p=[0.7, 0.3])), int(rng.integers(4, 7)))
    else:
        width, height = rng.uniform(0.8, 1.3), rng.uniform(1.4, 2.0)
        grid = (int(rng.integers(1, 3)), int(rng.integers(1, 4)))
    depth = rng.uniform(0.4, 0.62)
    lift, stand = _stand(rng, width, depth, rng.uniform(0.03, 0.18))
    top, lid = _top(rng, width, depth)
    body = (width, depth, height - lift - top)
    parts = [*stand, moved(lid, (0.0, 0.0, height - top))]
    if kind == "wardrobe":
        parts.append(moved(_wardrobe(rng, body, grid, style), (0.0, 0.0, lift)))
    else:
        parts.append(moved(carcass(rng, body, grid, style), (0.0, 0.0, lift)))
    if kind == "low" and rng.random() < 0.14:
        parts.append(_mirror(rng, width, depth, height))
    return joined(parts)


def night_stand(rng: np.random.Generator) -> TriangleMesh:
    """A small stand with drawers or open shelves, front to -y, 0.4 to 0.75 m high."""
    width = rng.uniform(0.38, 0.66)
    depth = float(np.clip(width * rng.uniform(0.58, 1.04), 0.33, 0.56))
    height = rng.uniform(0.42, 0.74)
    kind = str(
        rng.choice(["drawers", "shelf", "leggy", "door", "round"], p=[0.4, 0.2, 0.28, 0.08, 0.04])
    )
    if kind == "round":
        return _drum(rng, width, height)
    if kind == "leggy":
        return _leggy_stand(rng, width, depth, height)
    lift, stand = _stand(rng, width, depth, rng.uniform(0.03, 0.22))
    top, lid = _top(rng, width, depth)
    size = (width, depth, height - lift - top)
    if kind == "drawers":
        body = carcass(rng, size, (1, int(rng.integers(1, 4))))
    elif kind == "door":
        style = DrawerStyle.drawn(rng)
        body = joined([box(size), doors(rng, (width, size[2]), -depth / 2, style)])
    else:
        body = _with_shelf(rng, size)
    parts = [*stand, moved(body, (0.0, 0.0, lift)), moved(lid, (0.0, 0.0, height - top))]
    if rng.random() < 0.1:
        parts.append(_gallery(rng, width, depth, height))
    return joined(parts)


def _stand(
    rng: np.random.Generator, width: float, depth: float, lift: float
) -> tuple[float, list[TriangleMesh]]:
    """The base of a chest and its height: legs, a plinth, arches, or nothing."""
    kind = str(rng.choice(["legs", "plinth", "arches", "none"], p=[0.46, 0.18, 0.14, 0.22]))
    if kind == "none":
        return 0.0, []
    if kind == "plinth":
        shy = rng.uniform(0.9, 1.03)
        return lift, [box((width * shy, depth * shy, lift))]
    if kind == "arches":
        lift = max(lift, 0.07)
        return lift, [arched_plinth(width, depth, lift, 0.02)]
    thick = rng.uniform(0.03, 0.07)
    return lift, [four_legs(rng, (width - 1.2 * thick, depth - 1.2 * thick), lift, thick)]


def _top(rng: np.random.Generator, width: float, depth: float) -> tuple[float, TriangleMesh]:
    """The board on top and its thickness: flush or jutting out, its front straight or bowed."""
    top = rng.uniform(0.012, 0.045)
    jut = float(rng.choice([0.0, rng.uniform(0.005, 0.04)], p=[0.35, 0.65]))
    if rng.random() < 0.88:
        return top, box((width + 2 * jut, depth + jut, top), (0.0, -0.5 * jut, 0.0))
    x = np.linspace(-width / 2 - jut, width / 2 + jut, 17)
    bow = rng.uniform(0.02, 0.07) * (1 - (x / x[-1]) ** 2)
    return top, strip(x, -depth / 2 - jut - bow, depth / 2, 0.0, top, "z")


def _wardrobe(
    rng: np.random.Generator,
    size: tuple[float, float, float],
    grid: tuple[int, int],
    style: DrawerStyle,
) -> TriangleMesh:
    """Drawers below doors."""
    width, depth, height = size
    split = height * rng.uniform(0.2, 0.45)
    hollow = rng.random() < 0.4
    body = open_box(size, 0.02) if hollow else box(size)
    drawers = fronts(rng, (width, split), -depth / 2, grid, style)
    pair = doors(rng, (width, height - split), -depth / 2, style)
    return joined([body, drawers, moved(pair, (0.0, 0.0, split))])


def _mirror(rng: np.random.Generator, width: float, depth: float, height: float) -> TriangleMesh:
    """An upright mirror behind the top, square or arched."""
    half = width * rng.uniform(0.25, 0.45)
    tall = rng.uniform(0.45, 0.9)
    x = np.linspace(-half, half, 17)
    arch = rng.choice([0.0, rng.uniform(0.1, 0.3)]) * tall * (x / half) ** 2
    y = depth / 2 - 0.05
    return strip(x, height - 0.01, height + tall - arch, y, y + 0.04)


def _gallery(rng: np.random.Generator, width: float, depth: float, height: float) -> TriangleMesh:
    """A low board along the back of the top."""
    tall = rng.uniform(0.03, 0.12)
    return box((width, 0.018, tall), (0.0, depth / 2 - 0.009, height))


def _with_shelf(rng: np.random.Generator, size: tuple[float, float, float]) -> TriangleMesh:
    """An open carcass with a drawer, or with shelves alone."""
    width, depth, height = size
    board = rng.uniform(0.014, 0.03)
    parts = [open_box(size, board, back=rng.random() < 0.65)]
    if rng.random() < 0.75:
        drawer_high = height * rng.uniform(0.28, 0.5)
        base = height - board - drawer_high if rng.random() < 0.85 else board
        drawer = (width - 2 * board, depth - board, drawer_high)
        parts.append(moved(carcass(rng, drawer, (1, 1)), (0.0, 0.0, base)))
    else:
        for level in np.linspace(0.0, height, int(rng.integers(2, 4)) + 1)[1:-1]:
            parts.append(box((width - board, depth - board, board), (0.0, 0.0, level)))
    return joined(parts)


def _leggy_stand(
    rng: np.random.Generator, width: float, depth: float, height: float
) -> TriangleMesh:
    """A drawer on four long legs, perhaps with a shelf between them."""
    thick = rng.uniform(0.025, 0.055)
    top, lid = _top(rng, width, depth)
    drawer_high = height * rng.uniform(0.16, 0.45)
    lift = height - drawer_high - top
    parts = [
        four_legs(rng, (width - 1.1 * thick, depth - 1.1 * thick), lift + 0.01, thick),
        moved(carcass(rng, (width, depth, drawer_high), (1, 1)), (0.0, 0.0, lift)),
        moved(lid, (0.0, 0.0, height - top)),
    ]
    if rng.random() < 0.5:
        level = lift * rng.uniform(0.12, 0.5)
        parts.append(box((width - thick, depth - thick, 0.018), (0.0, 0.0, level)))
    return joined(parts)


def _drum(rng: np.random.Generator, width: float, height: float) -> TriangleMesh:
    """A round stand: a drum, an open level below it on four posts, and a foot."""
    plate = rng.uniform(0.015, 0.03)
    foot = height * rng.uniform(0.05, 0.4)
    drum = height * rng.uniform(0.2, 0.5)
    return joined(
        [
            cylinder(width * 0.95, foot, corners=32),
            four_legs(rng, (0.6 * width, 0.6 * width), height - plate, 0.035, "round"),
            cylinder(width * 0.95, drum, (0.0, 0.0, height - plate - drum), 32),
            slab(ellipse(width, width), plate, (0.0, 0.0, height - plate), 0.005),
        ]
    )
