"""Training objects as a network for scans was shown them: scanned once each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from circumspect.classification import GridRecipe, InputRecipe
from circumspect.datasets import ObjectSet
from circumspect.datasets.scan_augmentation import ScanAugmentation
from circumspect.datasets.scan_sources import of_point_set
from circumspect.errors import InputError
from circumspect.evaluation.held_back_scans import HeldBackScans, held_back_scans

SEED = 3
"""Of these scans; those that train have others."""


def scanned(
    objects: ObjectSet,
    training: Mapping[str, Any],
    recipe: InputRecipe,
    progress: Callable[[int, int], None] | None = None,
) -> HeldBackScans:
    """One scan of each object.

    Args:
        objects: Of the set that the network was trained on.
        training: How it was trained; its scans are made alike.
        recipe: What it is shown.
        progress: Called with (done, all) objects.

    Raises:
        InputError: The network was not trained on scans.
        MissingExtraError: Embree is not installed.
    """
    document = training.get("settings", {}).get("scan")
    if not isinstance(recipe, GridRecipe) or document is None:
        raise InputError("these weights were not trained on simulated scans")
    augmentation = ScanAugmentation.from_dict(document)
    return held_back_scans(
        [of_point_set(objects)], augmentation, recipe, 1, SEED, progress, keep_all=True
    )
