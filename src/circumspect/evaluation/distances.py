"""Distances of objects from the training objects of a classifier."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import OnnxClassifier
from circumspect.datasets import ObjectSet
from circumspect.evaluation.yaw_sweep import inputs_of


def nearest_distances(
    classifier: OnnxClassifier,
    objects: ObjectSet,
    yaw_deg: Sequence[float],
    progress: Callable[[int, int], None] | None = None,
) -> NDArray[np.float64]:
    """Distances of all objects at some yaws from the nearest training object.

    Args:
        classifier: Compares the features; its file holds its training objects.
        objects: The set.
        yaw_deg: y angles [deg].
        progress: Called with (done, all) objects.

    Returns:
        (y, n), see `NearExample`.

    Raises:
        InputError: An object spans no shape.
        WeightsError: The file does not hold its training objects.
    """
    yaws, found = np.deg2rad(yaw_deg).tolist(), []
    for index in range(len(objects)):
        found.append(classifier.distances(inputs_of(classifier.input_spec, objects, index, yaws)))
        if progress:
            progress(index + 1, len(objects))
    return np.stack(found, axis=1)
