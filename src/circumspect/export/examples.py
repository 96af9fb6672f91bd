"""A table of what a network makes of the objects that it was trained on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from circumspect.classification import ExampleTable, OnnxClassifier
from circumspect.classification.example_table import network_of
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError


def example_table(
    classifier: OnnxClassifier,
    objects: ObjectSet,
    progress: Callable[[int, int], None] | None = None,
) -> ExampleTable:
    """Features of all objects of a set, each as `classify` shows it.

    Args:
        classifier: Whose features they are.
        objects: The training split; never the test split.
        progress: Called with (done, all) objects.

    Raises:
        InputError: The set has other classes or no objects.
        WeightsError: The weights give no features.
    """
    if tuple(objects.classes) != classifier.classes or not len(objects):
        raise InputError(
            f"the set holds {len(objects)} objects of the classes {', '.join(objects.classes)}, "
            f"the classifier names {', '.join(classifier.classes)}"
        )
    rows = []
    for index in range(len(objects)):
        rows.append(classifier.features(classifier.recipe.inputs(objects.cloud(index)))[0])
        if progress is not None:
            progress(index + 1, len(objects))
    return ExampleTable(
        np.array(rows, np.float32),
        objects.labels,
        objects.names,
        classifier.classes,
        network_of(classifier),
    )
