"""Temperature, open-set model and bounds of confidence of a classifier, from held-back objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridSpec, OnnxClassifier
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.open_set import OpenSetRule
from circumspect.datasets.label_meaning import LabelUse, meaning_of
from circumspect.datasets.labelled_crops import LabelledCrops, require_usable_labels
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.evaluation.calibration import fitted_temperature, tempered
from circumspect.evaluation.confidence_fit import (
    MAX_ERROR_RATE,
    fitted_confidence,
    fitted_open_set,
    least_probability,
)
from circumspect.evaluation.held_back_scans import HeldBackScans


@dataclass(frozen=True, eq=False)
class Answers:
    """A classifier's answers to n objects.

    Attributes:
        probabilities: (n, c) of the classes.
        other: (n,) probability of "other".
        distance: (n,) to the nearest training object, or None.
        labels: (n,) text, any.
        coverage: (n,) share of the azimuth seen, NaN where unknown.
    """

    probabilities: NDArray[np.float64]
    other: NDArray[np.float64]
    distance: NDArray[np.float64] | None
    labels: NDArray[np.str_]
    coverage: NDArray[np.float64]

    @classmethod
    def of(cls, classifier: OnnxClassifier, scans: HeldBackScans) -> Answers:
        """Classify scans."""
        other, distance = classifier.open_set_signs(scans.inputs, scans.contexts)
        probabilities = classifier.probabilities(scans.inputs, scans.contexts)
        return cls(probabilities, other, distance, scans.labels, scans.coverage)

    @classmethod
    def joined(cls, parts: Sequence[Answers]) -> Answers:
        """Concatenate answers."""
        distances = [part.distance for part in parts if part.distance is not None]
        return cls(
            np.concatenate([part.probabilities for part in parts]),
            np.concatenate([part.other for part in parts]),
            np.concatenate(distances) if len(distances) == len(parts) else None,
            np.concatenate([part.labels for part in parts]),
            np.concatenate([part.coverage for part in parts]),
        )

    def subset(self, chosen: NDArray[np.bool_]) -> Answers:
        """The answers that a mask selects."""
        return Answers(
            self.probabilities[chosen],
            self.other[chosen],
            None if self.distance is None else self.distance[chosen],
            self.labels[chosen],
            self.coverage[chosen],
        )

    def correct(self, classes: Sequence[str]) -> NDArray[np.bool_]:
        """(n,) whether the most probable class is the label."""
        return np.array(classes)[self.probabilities.argmax(axis=1)] == self.labels


@dataclass(frozen=True)
class ClassifierCalibration:
    """The calibration in a classifier's file.

    Attributes:
        temperature: Divides the logits.
        open_set: None for a network without a class of other things.
        confidence: The bounds.
    """

    temperature: float
    open_set: OpenSetRule | None
    confidence: ConfidenceRule

    def to_dict(self) -> dict[str, Any]:
        """The entries in a file's description."""
        return {
            "temperature": self.temperature,
            "confidence": self.confidence.to_dict(),
            **({} if self.open_set is None else {"open_set": self.open_set.to_dict()}),
        }


def calibrate(
    classifier: OnnxClassifier,
    seen: Answers,
    files: Answers,
    real: Answers | None = None,
    max_error_rate: float = MAX_ERROR_RATE,
) -> ClassifierCalibration:
    """Fit temperature, open-set model and bounds of confidence.

    For the bound without coverage, all real objects together weigh as much as all simulated clouds.

    Args:
        classifier: The classifier of the answers.
        seen: Answers to scans with rays, whose coverage is known.
        files: Answers to clouds without rays: the same scans, and complete surfaces.
        real: Answers to real objects, without rays.
        max_error_rate: Largest error rate of the confident answers.

    Raises:
        InputError: No object of a class, or none of another kind though the network has a class of
            other things.
    """
    clouds = [files] if real is None else [files, real]
    every = Answers.joined([seen, *clouds])
    known = np.isin(every.labels, classifier.classes)
    labels = np.array([classifier.classes.index(name) for name in every.labels[known].tolist()])
    factor = fitted_temperature(every.probabilities[known], labels)
    open_set = None
    if classifier.other is not None:
        open_set = fitted_open_set(every.other, every.distance, known)

    weight = np.concatenate([np.full(len(part.labels), 1 / len(part.labels)) for part in clouds])
    all_clouds = Answers.joined(clouds)
    without = least_probability(
        judged(all_clouds, factor, open_set),
        all_clouds.correct(classifier.classes),
        max_error_rate,
        weight,
    )
    rule = fitted_confidence(
        judged(seen, factor, open_set), seen.correct(classifier.classes), seen.coverage,
        round(without, 4), max_error_rate,
    )  # fmt: skip
    return ClassifierCalibration(classifier.temperature * factor, open_set, rule)


def judged(
    answers: Answers, temperature: float, open_set: OpenSetRule | None
) -> NDArray[np.float64]:
    """(n,) probabilities of the answers; zero where an object is not in distribution."""
    probability = tempered(answers.probabilities, temperature).max(axis=1)
    if open_set is None:
        return probability
    belongs = open_set.probability(answers.other, answers.distance)
    return np.where(belongs >= open_set.threshold, probability, 0.0)


def real_answers(
    classifier: OnnxClassifier, crops: LabelledCrops
) -> tuple[Answers, NDArray[np.int64]]:
    """Classify real objects in metres, without coverage.

    Args:
        classifier: One that takes a context.
        crops: The objects.

    Returns:
        The answers, labelled with a class or "other", and the numbers of the objects. Objects with
        an ambiguous label are left out.

    Raises:
        InputError: See `require_usable_labels`.
    """
    require_usable_labels([crops], classifier.classes)
    input_spec = classifier.input_spec
    assert isinstance(input_spec, GridSpec)
    inputs, contexts, labels, chosen = [], [], [], []
    for index, label in enumerate(crops.labels.tolist()):
        meaning = meaning_of(label, classifier.classes)
        if meaning.use is LabelUse.LEFT_OUT:
            continue
        cloud = crops.cloud(index)
        inputs.append(input_spec.inputs(cloud)[0])
        contexts.append(input_spec.context(inputs[-1], input_spec.bounds(cloud)))
        labels.append(meaning.true_class or OTHER)
        chosen.append(index)
    unknown = np.full(len(labels), np.nan)
    scans = HeldBackScans(np.stack(inputs), np.array(contexts), np.array(labels), unknown)
    return Answers.of(classifier, scans), np.array(chosen)
