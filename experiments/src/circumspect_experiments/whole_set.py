"""The paper's published results, and a check that a set is ModelNet10."""

from __future__ import annotations

import numpy as np

from circumspect.classification import shipped
from circumspect.datasets import ObjectSet
from circumspect.datasets.verification import MODELNET10
from circumspect.errors import InputError
from circumspect.evaluation.predictor import check_classes, load_predictor

ANGLES_DEG = (0.0, 45.0, 90.0, 135.0)
"""Angles of section 4 [degrees]: training at the first, tests at all."""
PUBLISHED_ACCURACY = {
    ("rectangular", "max"): (0.82, 0.28, 0.43, 0.20),
    ("rectangular", "rwmp"): (0.82, 0.45, 0.41, 0.29),
    ("cylindrical", "max"): (0.88, 0.58, 0.28, 0.35),
    ("cylindrical", "rwmp"): (0.87, 0.86, 0.84, 0.83),
}
"""Table 2, ModelNet10: accuracy at `ANGLES_DEG` by grid and pooling."""
ROBOT = {
    ("rectangular", "max"): (0.91, 0.16, 0.33, 0.17),
    ("rectangular", "rwmp"): (0.92, 0.26, 0.46, 0.33),
    ("cylindrical", "max"): (0.93, 0.33, 0.33, 0.16),
    ("cylindrical", "rwmp"): (0.91, 0.89, 0.91, 0.88),
}
"""Table 2, the robot's own set: accuracy at `ANGLES_DEG` by grid and pooling."""


def require_modelnet10(train: ObjectSet, test: ObjectSet) -> None:
    """Check that both splits have objects of exactly the classes of ModelNet10.

    A table on other classes is not comparable with the paper's.

    Args:
        train: The training split.
        test: The test split.

    Raises:
        InputError: A class is missing, or is not in ModelNet10; the message names it.
    """
    errors = [*_errors("training", train), *_errors("test", test)]
    if errors:
        raise InputError(
            f"--data: {', '.join(errors)}; this experiment needs the {len(MODELNET10)} classes of "
            "ModelNet10: give a whole copy (circumspect data verify lists what one lacks)"
        )


def require_shipped_classes(train: ObjectSet, test: ObjectSet) -> None:
    """Check that a set is ModelNet10, with the classes of the shipped classifier `modelnet10`.

    Args:
        train: The training split.
        test: The test split.

    Raises:
        InputError: See `require_modelnet10`.
        WeightsError: The classifier has other classes than the test split.
    """
    require_modelnet10(train, test)
    check_classes(load_predictor(shipped.MODELNET10), test)


def _errors(split: str, objects: ObjectSet) -> list[str]:
    """Errors of a split; a class that a pack lists may have no objects."""
    present = {objects.classes[label] for label in np.unique(objects.labels)}
    missing = [name for name in MODELNET10 if name not in present]
    foreign = [name for name in objects.classes if name not in MODELNET10]
    return [
        *([f"the {split} split lacks {' and '.join(missing)}"] if missing else []),
        *([f"the {split} split has {' and '.join(foreign)}"] if foreign else []),
    ]
