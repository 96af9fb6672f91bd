"""Toilets: a bowl on a pedestal, seat and lid, and a tank behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circumspect.furniture.outlines import Outline, egg, rounded_rectangle
from circumspect.furniture.placement import joined, turned
from circumspect.furniture.primitives import cylinder, rounded_box, slab, stacked, tube
from circumspect.geometry import TriangleMesh

_CORNERS = 32


@dataclass(frozen=True)
class _Bowl:
    """The measures of a bowl whose middle is over the origin.

    Attributes:
        width: of the rim [m].
        length: of the rim, front to back [m].
        rim: its height [m].
        taper: how much narrower the front is, see `outlines.egg`.
    """

    width: float
    length: float
    rim: float
    taper: float

    def outline(self, share: float = 1.0) -> Outline:
        """The rim, or a smaller one about the same middle."""
        return egg(self.width * share, self.length * share, self.taper, _CORNERS)


def toilet(rng: np.random.Generator) -> TriangleMesh:
    """A toilet with its tank to +y, rim about 0.4 m high."""
    bowl = _Bowl(
        width=rng.uniform(0.34, 0.44),
        length=rng.uniform(0.42, 0.58),
        rim=rng.uniform(0.36, 0.44),
        taper=rng.uniform(0.0, 0.45),
    )
    body = str(rng.choice(["pedestal", "skirted", "wall"], p=[0.62, 0.28, 0.1]))
    back = str(rng.choice(["tank", "low", "high", "none"], p=[0.7, 0.1, 0.06, 0.14]))
    if body == "wall" and back in ("tank", "high"):
        back = "none"
    deep = rng.uniform(0.14, 0.24)
    parts = [_basin(rng, bowl, body), _neck(rng, bowl, body, deep)]
    behind = bowl.length / 2 + 0.02
    parts += _tank(rng, bowl, back, behind, deep)
    parts += _seat_and_lid(rng, bowl, lid_room=back != "high")
    return joined(parts)


def _basin(rng: np.random.Generator, bowl: _Bowl, body: str) -> TriangleMesh:
    """Outside from the foot to the rim, then inside down to the water."""
    waist = {"pedestal": rng.uniform(0.4, 0.6), "skirted": rng.uniform(0.72, 0.95), "wall": 0.75}[
        body
    ]
    foot = waist * (rng.uniform(1.05, 1.35) if body == "pedestal" else 1.0)
    levels = np.array([0.0, 0.12, 0.3, 0.5, 0.7, 0.85, 0.94, 1.0, 1.0, 0.9, 0.62, 0.45])
    if body == "wall":
        levels[:7] = np.linspace(0.25, 0.94, 7)
    knots = np.array([0.0, 0.15, 0.35, 0.62, 0.9, 1.0])
    outside = np.interp(levels[:8], knots, [foot, waist, waist, 0.72 + 0.2 * waist, 0.99, 1.0])
    if body == "wall":
        outside = np.interp(levels[:8], [0.25, 0.6, 1.0], [0.35, 0.8, 1.0])
    shares = np.concatenate([outside, [0.76, 0.72, 0.5, 0.22]])
    rings = np.stack([bowl.outline(share) for share in shares])
    # The foot stands further back than the rim.
    setback = rng.uniform(0.1, 0.45) * bowl.length * (1 - shares[:8])
    rings[:8, :, 1] += setback[:, None]
    return stacked(rings, levels * bowl.rim)


def _neck(rng: np.random.Generator, bowl: _Bowl, body: str, deep: float) -> TriangleMesh:
    """The connection of the bowl to the wall: a box under the tank, to the floor or hanging."""
    wide = bowl.width * rng.uniform(0.5, 0.75)
    front = bowl.length * rng.uniform(0.1, 0.3)
    rear = bowl.length / 2 + deep * rng.uniform(0.6, 1.0)
    low = 0.0 if body != "wall" else 0.3 * bowl.rim
    if body == "pedestal" and rng.random() < 0.4:
        low = rng.uniform(0.3, 0.7) * bowl.rim
    size = (wide, rear - front, bowl.rim - low - 0.005)
    return rounded_box(size, (0.0, (front + rear) / 2, low), 0.03)


def _tank(
    rng: np.random.Generator, bowl: _Bowl, kind: str, front: float, deep: float
) -> list[TriangleMesh]:
    """The cistern and its lid: on the bowl, as part of it, or high on a pipe."""
    if kind == "none":
        return []
    wide = rng.uniform(0.4, 0.55)
    base, tall = bowl.rim - 0.02, rng.uniform(0.28, 0.44)
    if kind == "low":
        tall = rng.uniform(0.12, 0.22)
    elif kind == "high":
        base = bowl.rim + rng.uniform(0.25, 0.5)
        wide *= 0.9
    y = front + deep / 2
    narrow = rng.uniform(0.8, 1.0)
    outline = rounded_rectangle(wide, deep, rng.uniform(0.01, 0.06), 4)
    tank = stacked([outline * (narrow, 1.0), outline], [0.0, tall], (0.0, y, base))
    cover = rounded_rectangle(wide + 0.025, deep + 0.02, 0.02, 4)
    parts = [tank, slab(cover, rng.uniform(0.02, 0.045), (0.0, y, base + tall), 0.01)]
    if kind == "high":
        pipe = rng.uniform(0.03, 0.06)
        parts.append(tube([(0.0, y, bowl.rim - 0.03), (0.0, y, base + 0.01)], pipe))
    if rng.random() < 0.5:
        x, z = -wide * 0.32, base + 0.8 * tall
        parts.append(tube([(x, front, z), (x, front - 0.03, z)], 0.02))
        parts.append(tube([(x, front - 0.025, z), (x + 0.08, front - 0.025, z - 0.01)], 0.014))
    else:
        parts.append(cylinder(0.04, 0.02, (0.0, y, base + tall + 0.03), 12))
    return parts


def _seat_and_lid(rng: np.random.Generator, bowl: _Bowl, lid_room: bool) -> list[TriangleMesh]:
    """The ring to sit on and its lid, closed or turned up."""
    thick = rng.uniform(0.012, 0.022)
    hinge = (0.0, bowl.length / 2 - 0.02, bowl.rim + thick)
    level = bowl.rim + 0.002
    cover = slab(bowl.outline(1.02), thick, (0.0, 0.0, level + thick), 0.4 * thick)
    ring = _ring(bowl, level, thick)
    up = rng.choice(["closed", "lid", "both", "bare"], p=[0.42, 0.3, 0.08, 0.2])
    # Upright it leans on the tank, or on the wall where there is none.
    lean = rng.uniform(1.5, 1.6) if lid_room else rng.uniform(1.5, 1.75)
    if up == "closed":
        return [ring, cover]
    if up == "lid":
        return [ring, turned(cover, -lean, "x", hinge)]
    if up == "both":
        return [turned(ring, -lean + 0.05, "x", hinge), turned(cover, -lean, "x", hinge)]
    return [ring]


def _ring(bowl: _Bowl, level: float, thick: float) -> TriangleMesh:
    """A flat ring above the rim: a loft that turns round its own section."""
    shares = [1.02, 1.02, 0.7, 0.7, 1.02]
    heights = np.array([0.0, thick, thick, 0.0, 0.0])
    rings = np.stack([bowl.outline(share) for share in shares])
    flat = stacked(rings, heights, (0.0, 0.0, level))
    # Without the two caps that a stack closes with: a ring is open in its middle.
    return TriangleMesh(flat.vertices_xyz, flat.faces[: -2 * _CORNERS])
