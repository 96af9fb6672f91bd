"""The ten categories of ModelNet10 and the one function that makes a piece of each."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches

import numpy as np

from circumspect.errors import InputError
from circumspect.furniture.bathtubs import bathtub
from circumspect.furniture.beds import bed
from circumspect.furniture.cabinets import dresser, night_stand
from circumspect.furniture.chairs import chair
from circumspect.furniture.desks import desk
from circumspect.furniture.monitors import monitor
from circumspect.furniture.placement import placed_on_floor, turned
from circumspect.furniture.sofas import sofa
from circumspect.furniture.tables import table
from circumspect.furniture.toilets import toilet
from circumspect.geometry import TriangleMesh

_MAKERS: dict[str, Callable[[np.random.Generator], TriangleMesh]] = {
    "bathtub": bathtub,
    "bed": bed,
    "chair": chair,
    "desk": desk,
    "dresser": dresser,
    "monitor": monitor,
    "night_stand": night_stand,
    "sofa": sofa,
    "table": table,
    "toilet": toilet,
}
CATEGORIES: tuple[str, ...] = tuple(_MAKERS)
"""The categories of ModelNet10 in alphabetical order."""

_BACK_TOWARDS_Y = frozenset({"bed", "chair", "toilet"})
"""ModelNet10 turns these with their backs (heads) to +y; the rest face -x, long side along y."""


def make_furniture(category: str, seed: int) -> TriangleMesh:
    """One piece of furniture with proportions of its own.

    It stands on z = 0, the middle of its bounding box is on the z axis, and it is turned as in
    ModelNet10: chairs, toilets and beds have their backs to +y; the others have their long side
    along y and their front to -x.

    Args:
        category: One of `CATEGORIES`.
        seed: Not negative; the same seed gives the same piece.

    Returns:
        Triangles of realistic size [m]; parts touch and overlap where they are joined.

    Raises:
        InputError: No such category, or a negative seed.
    """
    if category not in _MAKERS:
        raise InputError(_unknown(category))
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")
    rng = np.random.default_rng([CATEGORIES.index(category), seed])
    mesh = _MAKERS[category](rng)
    if category not in _BACK_TOWARDS_Y:
        mesh = turned(mesh, -np.pi / 2)
    return placed_on_floor(mesh)


def _unknown(category: str) -> str:
    near = get_close_matches(category, CATEGORIES, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"no category {category!r}; {hint}known: {', '.join(CATEGORIES)}"
