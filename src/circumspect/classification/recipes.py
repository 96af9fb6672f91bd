"""Every recipe by its kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.input_recipe import InputRecipe
from circumspect.classification.points_recipe import PointsRecipe
from circumspect.errors import InputError


def recipe_from_dict(document: Mapping[str, Any]) -> InputRecipe:
    """Read back what `InputRecipe.to_dict` made.

    Raises:
        InputError: Unknown entries, or values out of range.
    """
    if not isinstance(document, Mapping):
        raise InputError(f"the settings of inputs must be an object, not {document!r:.40}")
    recipe = PointsRecipe if document.get("kind") == "points" else GridRecipe
    known = {field.name for field in fields(recipe)}
    if unknown := set(document) - known:
        raise InputError(f"unknown settings {sorted(unknown)}; known: {sorted(known)}")
    return recipe(**document)
