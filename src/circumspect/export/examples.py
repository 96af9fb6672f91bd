"""A table of what a network makes of the objects that it was trained on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from circumspect.classification import ExampleTable, OnnxClassifier
from circumspect.classification.example_table import network_of
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError
from circumspect.export.scan_examples import scanned


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
    learnt = learnt_objects(classifier.classes, classifier.training, objects)
    rows = []
    if classifier.recipe.takes_context:
        # As the network was trained: a scan of each.
        scans = scanned(learnt, classifier.training, classifier.recipe, progress)
        if len(scans.labels) != len(learnt):
            raise InputError("an object of the set can not be scanned")
        features = classifier.features(scans.inputs, scans.contexts)
        return ExampleTable(
            features.astype(np.float32), learnt.labels, learnt.names, classifier.classes,
            network_of(classifier),
        )  # fmt: skip
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


def learnt_objects(
    classes: tuple[str, ...], training: Mapping[str, Any], objects: ObjectSet
) -> ObjectSet:
    """The part of a set that a network was fitted to.

    Args:
        classes: That the network names.
        training: How it was trained; see `Checkpoint`.
        objects: The set.

    Raises:
        InputError: The set has other classes, or the network was fitted to none of its objects.
    """
    if tuple(objects.classes) != classes:
        raise InputError(
            f"the set holds objects of the classes {', '.join(objects.classes)}, the classifier "
            f"names {', '.join(classes)}"
        )
    learnt = objects.subset(fitted_objects(training, objects))
    if not len(learnt):
        raise InputError(
            f"the weights were trained on none of the set's {len(objects)} objects; give the set "
            "that they were trained on"
        )
    return learnt
