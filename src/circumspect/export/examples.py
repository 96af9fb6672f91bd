"""A table of what a network makes of the objects that it was trained on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from circumspect.classification import ExampleTable, OnnxClassifier
from circumspect.classification.example_table import network_of
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError


def example_table(
    classifier: OnnxClassifier,
    objects: ObjectSet,
    progress: Callable[[int, int], None] | None = None,
) -> ExampleTable:
    """Features of those objects of a set that a network was fitted to, as `classify` shows them.

    Args:
        classifier: Whose features they are.
        objects: The set that it was trained on; what was held back of it is left out.
        progress: Called with (done, all) objects.

    Raises:
        InputError: The set has other classes, or the network was fitted to none of its objects.
        WeightsError: The weights give no features.
    """
    if tuple(objects.classes) != classifier.classes:
        raise InputError(
            f"the set holds objects of the classes {', '.join(objects.classes)}, the classifier "
            f"names {', '.join(classifier.classes)}"
        )
    learnt = objects.subset(fitted_objects(classifier.training, objects))
    if not len(learnt):
        raise InputError(
            f"the weights were trained on none of the set's {len(objects)} objects; give the set "
            "that they were trained on"
        )
    rows = []
    for index in range(len(learnt)):
        rows.append(classifier.features(classifier.recipe.inputs(learnt.cloud(index)))[0])
        if progress is not None:
            progress(index + 1, len(learnt))
    return ExampleTable(
        np.array(rows, np.float32),
        learnt.labels,
        learnt.names,
        classifier.classes,
        network_of(classifier),
    )
