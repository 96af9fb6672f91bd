"""The table of a network's features of its training objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from circumspect.classification import ExampleTable, GridSpec, InputSpec, OnnxClassifier
from circumspect.classification.example_table import network_of
from circumspect.datasets.fitted_objects import fitted_objects
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.scan_augmentation import ScanAugmentation
from circumspect.datasets.scan_sources import of_point_set
from circumspect.errors import InputError
from circumspect.evaluation.held_back_scans import HeldBackScans, held_back_scans

SEED = 3
"""Seed of these scans; those for training have others."""


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
    if classifier.input_spec.takes_context:
        # As in training: a scan of each object.
        scans = scanned(learnt, classifier.training, classifier.input_spec, progress)
        if len(scans.labels) != len(learnt):
            raise InputError("an object of the set can not be scanned")
        features = classifier.features(scans.inputs, scans.contexts)
        return ExampleTable(
            features.astype(np.float32), learnt.labels, learnt.names, classifier.classes,
            network_of(classifier),
        )  # fmt: skip
    for index in range(len(learnt)):
        rows.append(classifier.features(classifier.input_spec.inputs(learnt.cloud(index)))[0])
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
    """The part of a set that a network was trained on.

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


def scanned(
    objects: ObjectSet,
    training: Mapping[str, Any],
    input_spec: InputSpec,
    progress: Callable[[int, int], None] | None = None,
) -> HeldBackScans:
    """One simulated scan of each object.

    Args:
        objects: Of the set that the network was trained on.
        training: How it was trained; these scans use the same settings.
        input_spec: What it is shown.
        progress: Called with (done, all) objects.

    Raises:
        InputError: The network was not trained on scans.
        MissingExtraError: Embree is not installed.
    """
    document = training.get("settings", {}).get("scan")
    if not isinstance(input_spec, GridSpec) or document is None:
        raise InputError("these weights were not trained on simulated scans")
    augmentation = ScanAugmentation.from_dict(document)
    return held_back_scans(
        [of_point_set(objects)], augmentation, input_spec, 1, SEED, progress, keep_all=True
    )
