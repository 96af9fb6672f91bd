"""Identification of the objects that a network was trained on."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.model_description import OBJECTS
from circumspect.datasets.gathered_set import scanned_name
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.validation_split import validation_split


def fitted_objects(training: Mapping[str, Any], objects: ObjectSet) -> NDArray[np.bool_]:
    """Mark the objects that a network was trained on, by their names.

    Another copy of a set (sampled again, a part of it, or with more objects) has the same objects
    under the same names. Other scans of an object show the same object. Records of older versions
    have no names and apply only to their own set.

    Args:
        training: Record of the training; see `Checkpoint`.
        objects: Any set.

    Returns:
        (n,) whether the network was trained on the object or on another scan of it.

    Raises:
        InputError: An object spans no shape.
    """
    names = training.get(OBJECTS)
    if isinstance(names, list):
        known = {name for name in names if isinstance(name, str)}
        return _named(objects.names, known) | _scanned(objects, known)
    if training.get("data") != objects.digest:
        return np.zeros(len(objects), bool)
    settings = training.get("settings", {})
    if not settings.get("validation", True):
        return np.ones(len(objects), bool)
    return ~validation_split(objects, settings.get("validation_salt", ""))


def _named(names: NDArray[np.str_], known: Collection[str | None]) -> NDArray[np.bool_]:
    return np.array([name in known for name in names.tolist()], bool)


def _scanned(objects: ObjectSet, known: Collection[str]) -> NDArray[np.bool_]:
    """(n,) objects with a scan among the known names."""
    if objects.scan_of is None:
        return np.zeros(len(objects), bool)
    return _named(objects.scan_of, {scanned_name(name) for name in known})
