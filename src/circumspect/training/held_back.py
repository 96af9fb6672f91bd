"""What trains, and what is held back from it."""

from __future__ import annotations

import numpy as np

from circumspect.datasets import ObjectSet
from circumspect.datasets.validation_split import validation_split
from circumspect.errors import InputError
from circumspect.training.settings import TrainingSettings


def fitted_and_held_back(
    objects: ObjectSet, settings: TrainingSettings
) -> tuple[ObjectSet, ObjectSet]:
    """Divide the training objects.

    Args:
        objects: The official training split.
        settings: Say whether objects are held back, and which.

    Returns:
        Those that train, and those held back, which may be none.

    Raises:
        InputError: A class has no object that trains, or none is held back where some should be.
    """
    held_back = np.zeros(len(objects), bool)
    if settings.validation:
        held_back = validation_split(objects, settings.validation_salt)
    fit = objects.subset(~held_back)
    if missing := set(range(len(objects.classes))) - set(fit.labels.tolist()):
        names = ", ".join(objects.classes[i] for i in sorted(missing))
        raise InputError(f"no training object of class {names}; complete the data set")
    if settings.validation and not held_back.any():
        raise InputError(
            "no object falls into the validation split; add objects, or train with --no-validation"
        )
    return fit, objects.subset(held_back)
