"""The few solids that all furniture is built from.

Lengths are metres. `base` is the centre of a solid's underside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.furniture.outlines import (
    Outline,
    ellipse,
    rectangle,
    regular,
    rounded_rectangle,
    superellipse,
)
from circumspect.geometry import TriangleMesh

ORIGIN = (0.0, 0.0, 0.0)


def loft(rings: ArrayLike, caps: bool = True) -> TriangleMesh:
    """The skin over a stack of rings.

    Args:
        rings: (k, n, 3) k closed rings of n corners each, counter-clockwise seen from the
            side that the stack grows to.
        caps: Close the first and the last ring with a fan about their centres.
    """
    stack = np.asarray(rings, dtype=np.float64)
    levels, corners, _ = stack.shape
    this = np.arange(levels * corners).reshape(levels, corners)
    after = np.roll(this, -1, axis=1)
    a, b, c, d = (x.ravel() for x in (this[:-1], after[:-1], after[1:], this[1:]))
    faces = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    vertices = [stack.reshape(-1, 3)]
    if caps:
        vertices += [stack[[0, -1]].mean(axis=1)]
        first, last = levels * corners, levels * corners + 1
        faces += [
            np.stack([after[0], this[0], np.full(corners, first)], axis=1),
            np.stack([this[-1], after[-1], np.full(corners, last)], axis=1),
        ]
    return TriangleMesh(np.concatenate(vertices), np.concatenate(faces))


def stacked(outlines: ArrayLike, heights: ArrayLike, base: ArrayLike = ORIGIN) -> TriangleMesh:
    """A loft over level outlines (k, n, 2) at the heights (k,) above `base`."""
    flat = np.asarray(outlines, dtype=np.float64)
    level = np.broadcast_to(np.asarray(heights)[:, None, None], (*flat.shape[:2], 1))
    return loft(np.concatenate([flat, level], axis=2) + np.asarray(base))


def prism(outline: Outline, height: float, base: ArrayLike = ORIGIN) -> TriangleMesh:
    """An outline extruded upwards; star-shaped about the mean of its corners."""
    return stacked([outline, outline], [0.0, height], base)


def box(size: tuple[float, float, float], base: ArrayLike = ORIGIN) -> TriangleMesh:
    """A box of (width, depth, height)."""
    return prism(rectangle(size[0], size[1]), size[2], base)


def cylinder(
    width: float, height: float, base: ArrayLike = ORIGIN, corners: int = 24
) -> TriangleMesh:
    """An upright cylinder of a diameter."""
    return prism(ellipse(width, width, corners), height, base)


def slab(outline: Outline, height: float, base: ArrayLike, edge: float) -> TriangleMesh:
    """An outline extruded upwards, its rims rounded off.

    Args:
        outline: (n, 2) [m].
        height: [m].
        base: (3,) [m].
        edge: Radius of the rims [m]; cut to what the height and the outline allow.
    """
    half = np.ptp(outline, axis=0) / 2
    edge = min(edge, 0.999 * height / 2, 0.9 * float(half.min()))
    turn = np.linspace(0.0, np.pi / 2, 4)
    inset = edge * (1 - np.sin(turn))
    rise = edge * (1 - np.cos(turn))
    shares = 1 - np.concatenate([inset, inset[::-1]])[:, None] / half
    heights = np.concatenate([rise, height - rise[::-1]])
    return stacked(outline[None] * shares[:, None, :], heights, base)


def rounded_box(
    size: tuple[float, float, float], base: ArrayLike = ORIGIN, radius: float = 0.03
) -> TriangleMesh:
    """A box with round edges: a cushion, a mattress, a moulded case."""
    width, depth, height = size
    return slab(rounded_rectangle(width, depth, radius, steps=3), height, base, radius)


def pillow(size: tuple[float, float, float], base: ArrayLike = ORIGIN) -> TriangleMesh:
    """A stuffed pillow: thick in the middle, thin at its seam."""
    width, depth, height = size
    turn = np.linspace(-np.pi / 2, np.pi / 2, 9)
    shares = np.maximum(np.cos(turn), 0.02) ** 0.45
    outline = superellipse(width, depth, 4.0, 24)
    return stacked(outline[None] * shares[:, None, None], (np.sin(turn) + 1) * height / 2, base)


def leg(
    foot: ArrayLike, top: ArrayLike, foot_width: float, top_width: float, sides: int = 4
) -> TriangleMesh:
    """A straight leg with level ends, square (4 sides) or round, that may taper and splay.

    Args:
        foot: (3,) [m] centre of its lower end.
        top: (3,) [m] centre of its upper end.
        foot_width: [m] at the lower end.
        top_width: [m] at the upper end.
        sides: Of its section.
    """
    ends = np.array([foot, top], dtype=np.float64)
    section = regular(sides, 1.0)
    outlines = section[None] * np.array([foot_width, top_width])[:, None, None]
    flat = outlines + ends[:, None, :2]
    return stacked(flat, ends[:, 2])


def revolved(profile: ArrayLike, base: ArrayLike = ORIGIN, corners: int = 20) -> TriangleMesh:
    """A profile turned about the upright axis through `base`.

    Args:
        profile: (k, 2) [m] radius and height, from the first cap over the outside to the last.
        base: (3,) [m].
        corners: Of each ring.
    """
    radii, heights = np.asarray(profile, dtype=np.float64).T
    return stacked(ellipse(2.0, 2.0, corners)[None] * radii[:, None, None], heights, base)


def tube(path: ArrayLike, width: float | ArrayLike, sides: int = 8) -> TriangleMesh:
    """A rod that follows a path, square (4 sides) or round.

    Args:
        path: (k, 3) [m] the middle line, k >= 2, without doubled points.
        width: [m] one width, or (k,) one a point.
        sides: Of its section.
    """
    line = np.asarray(path, dtype=np.float64)
    widths = np.broadcast_to(np.asarray(width, dtype=np.float64), (len(line),))
    across, up = _frames(line)
    section = regular(sides, 1.0)[None, :, :, None] * widths[:, None, None, None]
    return loft(line[:, None] + section[:, :, 0] * across[:, None] + section[:, :, 1] * up[:, None])


def _frames(line: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit vectors across the path at each point, turning as little as possible."""
    tangents = np.gradient(line, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    guide = np.array([0.0, 0.0, 1.0] if abs(tangents[0, 2]) < 0.9 else [0.0, 1.0, 0.0])
    ups = np.empty_like(line)
    for k, tangent in enumerate(tangents):
        guide = guide - tangent * (guide @ tangent)
        guide = guide / np.linalg.norm(guide)
        ups[k] = guide
    across: NDArray[np.float64] = np.cross(ups, tangents).astype(np.float64)
    return across, ups


def strip(
    along: ArrayLike, low: ArrayLike, high: ArrayLike, start: float, stop: float, axis: str = "y"
) -> TriangleMesh:
    """A board between a lower and an upper curve: a shaped headboard, an arched apron.

    Args:
        along: (n,) [m] rising positions along the first axis of the board's plane.
        low: (n,) or () [m] lower curve, along the second axis of the plane.
        high: (n,) or () [m] upper curve, above the lower everywhere.
        start: Where the board begins along `axis` [m].
        stop: Where it ends, beyond `start` [m].
        axis: The direction of its thickness: "y" (plane x, z), "x" (plane y, z) or "z"
            (plane x, y).
    """
    u = np.asarray(along, dtype=np.float64)
    count = len(u)
    curves = [np.stack([u, np.broadcast_to(np.asarray(v), (count,))], axis=1) for v in (low, high)]
    flat = np.concatenate([curves[0], curves[1][::-1]])
    ring = 2 * count
    first = np.arange(count - 1)
    last = ring - 1 - first
    face = np.concatenate(
        [np.stack([first, first + 1, last - 1], axis=1), np.stack([first, last - 1, last], axis=1)]
    )
    here = np.arange(ring)
    after = np.roll(here, -1)
    faces = np.concatenate(
        [
            face[:, ::-1],
            face + ring,
            np.stack([here, after, after + ring], axis=1),
            np.stack([here, after + ring, here + ring], axis=1),
        ]
    )
    depth = np.repeat([start, stop], ring)[:, None]
    plane = np.concatenate([flat, flat])
    order, flip = {"z": ([0, 1, 2], 1), "y": ([0, 2, 1], -1), "x": ([2, 0, 1], 1)}[axis]
    vertices = np.concatenate([plane, depth], axis=1)[:, order]
    return TriangleMesh(vertices, faces[:, ::flip])
