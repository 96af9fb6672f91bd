"""What sets the config that a folder holds apart from the one that is asked for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from circumspect.classification import GridRecipe, PointsRecipe
from circumspect.training.settings import TrainingSettings

LONGEST = 24
"""Longer values are not told [characters]."""
LATER = ("margin", "staggered", "visibility", "metric", "scale_required", "farthest_first")
"""Of a recipe: what came after the first runs were stored."""
MOST = 4
"""More differences are counted, not named."""


def config_differences(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """Name what differs, such as "settings.epochs (6, not 24)"; no text where nothing does.

    Args:
        stored: What the folder holds, as JSON types.
        asked: What is asked for, as JSON types.
    """
    held, wanted = _flat(_completed(stored)), _flat(asked)
    differing = [key for key in {**wanted, **held} if _differ(key, held, wanted)]
    named = [_named(key, held, wanted) for key in differing[:MOST]]
    more = [f"{len(differing) - MOST} more"] if len(differing) > MOST else []
    return ", ".join(named + more)


def _completed(stored: Mapping[str, Any]) -> Mapping[str, Any]:
    """With the settings that came after it was stored: their defaults mean what was done before."""
    settings = json.loads(json.dumps(TrainingSettings().to_dict()))
    found = {
        name: stored[name] for name in ("settings", "grid") if isinstance(stored.get(name), dict)
    }
    points = found.get("grid", {}).get("kind") == "points"
    recipe = (PointsRecipe() if points else GridRecipe()).to_dict()
    later = {name: recipe[name] for name in LATER if name in recipe}
    defaults = {"settings": settings, "grid": later}
    return {**stored, **{name: _filled(part, defaults[name]) for name, part in found.items()}}


def _filled(found: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    filled = {**defaults, **found}
    for name, default in defaults.items():
        if isinstance(default, dict) and isinstance(filled[name], dict):
            filled[name] = _filled(filled[name], default)
    return filled


def _flat(document: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """The single values under dotted names."""
    flat: dict[str, Any] = {}
    for name, value in document.items():
        inner = isinstance(value, dict) and value
        flat |= _flat(value, f"{above}{name}.") if inner else {f"{above}{name}": value}
    return flat


def _differ(key: str, held: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    return (key in held) != (key in wanted) or held[key] != wanted[key]


def _named(key: str, held: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    if key in held and key in wanted:
        values = json.dumps(held[key]), json.dumps(wanted[key])
        if max(map(len, values)) <= LONGEST:
            return f"{key} ({values[0]}, not {values[1]})"
    return key
