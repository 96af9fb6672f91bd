"""Whether a set is what the published figures are of."""

from __future__ import annotations

import numpy as np

from circumspect.datasets import ObjectSet
from circumspect.datasets.verification import MODELNET10
from circumspect.errors import InputError


def require_modelnet10(train: ObjectSet, test: ObjectSet) -> None:
    """That both splits have objects of all classes of ModelNet10, and no class beyond.

    A table on fewer or other classes would stand beside the paper's as if it were the same.

    Args:
        train: The training split.
        test: The test split.

    Raises:
        InputError: A class is missing, or is none of ModelNet10's; the message names it.
    """
    faults = [*_faults("training", train), *_faults("test", test)]
    if faults:
        raise InputError(
            f"--data: {', '.join(faults)}; this experiment is of the {len(MODELNET10)} classes of "
            "ModelNet10: give a whole copy (circumspect data verify tells what one lacks)"
        )


def _faults(split: str, objects: ObjectSet) -> list[str]:
    """A class that a pack lists may have no object all the same."""
    there = {objects.classes[label] for label in np.unique(objects.labels)}
    lacking = [name for name in MODELNET10 if name not in there]
    beyond = [name for name in objects.classes if name not in MODELNET10]
    return [
        *([f"the {split} split lacks {' and '.join(lacking)}"] if lacking else []),
        *([f"the {split} split has {' and '.join(beyond)}"] if beyond else []),
    ]
