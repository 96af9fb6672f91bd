"""Measures of a classifier on labelled real objects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from circumspect.datasets.label_meaning import LabelUse
from circumspect.evaluation.accuracy import area_under_curve, confusion_matrix, wilson_interval
from circumspect.evaluation.crop_answers import CropAnswer

BIN_EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 1.0)
"""Edges of the bins of probability; a bin includes its upper edge."""
Answers = Sequence[CropAnswer]


def crop_metrics(answers: Answers, classes: Sequence[str]) -> dict[str, Any]:
    """All measures as JSON types; rates are fractions of 1.

    Args:
        answers: From `answer_crops`; at least one.
        classes: Of the classifier.
    """
    known, other = used_as(answers, LabelUse.KNOWN_CLASS), used_as(answers, LabelUse.OTHER_KIND)
    left_out = used_as(answers, LabelUse.LEFT_OUT)
    return {
        "classes": list(classes),
        "objects": {
            "all": len(answers), "known_classes": len(known), "other_kinds": len(other),
            "left_out": len(left_out),
        },
        "labels": {
            use.value: dict(sorted(Counter(a.label for a in answers if a.use is use).items()))
            for use in LabelUse
        },
        "overall": accuracy_of(known),
        "per_source": _grouped(known, lambda answer: answer.source),
        "per_scene": _per_scene(known),
        "per_class": _grouped(known, lambda answer: answer.true_class),
        "confusion": _confusion(known, classes),
        "other_kind_answers": _answers_to_others(other),
        "confident": confidence_of(known, other),
        "probability_bins": probability_bins(known),
        "expected_calibration_error": calibration_error(known),
        "open_set": open_set_of(known, other),
    }  # fmt: skip


def used_as(answers: Answers, use: LabelUse) -> list[CropAnswer]:
    """The answers to objects that count."""
    return [answer for answer in answers if answer.use is use]


def share(hits: int, count: int) -> dict[str, Any]:
    """A proportion with its 95 % interval; both None for a count of 0."""
    return {
        "objects": count,
        "hits": hits,
        "share": hits / count if count else None,
        "interval": list(wilson_interval(hits, count)) if count else None,
    }


def accuracy_of(known: Answers) -> dict[str, Any]:
    """Accuracy, mean per-class accuracy and top-2 accuracy over objects of known classes."""
    correct = [answer.correct for answer in known]
    per_class = _grouped(known, lambda answer: answer.true_class).values()
    return {
        "accuracy": share(sum(correct), len(known)),
        "mean_class_accuracy": _mean(row["share"] for row in per_class),
        "top_2": share(sum(a.true_class in (a.answer, a.second) for a in known), len(known)),
    }


def _mean(values: Iterable[float]) -> float | None:
    listed = list(values)
    return float(np.mean(listed)) if listed else None


def _grouped(known: Answers, key: Callable[[CropAnswer], str]) -> dict[str, Any]:
    """Accuracy of each group, in alphabetical order."""
    groups: dict[str, list[bool]] = {}
    for answer in known:
        groups.setdefault(key(answer), []).append(answer.correct)
    return {name: share(sum(row), len(row)) for name, row in sorted(groups.items())}


def _per_scene(known: Answers) -> list[dict[str, Any]]:
    """Accuracy of each room; two files may have rooms of the same name."""
    groups: dict[tuple[str, str], list[bool]] = {}
    for answer in known:
        groups.setdefault((answer.source, answer.scene), []).append(answer.correct)
    return [
        {"source": source, "scene": scene, **share(sum(row), len(row))}
        for (source, scene), row in sorted(groups.items())
    ]


def _confusion(known: Answers, classes: Sequence[str]) -> list[list[int]]:
    """(c, c) counts: row is the true class, column the answer."""
    number = {name: k for k, name in enumerate(classes)}
    labels = np.array([number[answer.true_class] for answer in known], np.int64)
    answered = np.array([number[answer.answer] for answer in known], np.int64)
    return confusion_matrix(labels, answered, len(classes)).tolist()


def _answers_to_others(other: Answers) -> dict[str, dict[str, int]]:
    """Label of another kind to answer to count."""
    found: dict[str, Counter[str]] = {}
    for answer in other:
        found.setdefault(answer.label, Counter())[answer.answer] += 1
    return {label: dict(counts.most_common()) for label, counts in sorted(found.items())}


def confidence_of(known: Answers, other: Answers) -> dict[str, Any]:
    """Number of confident answers, and how many of them are correct.

    "all" joins both: a confident answer to an object of another kind is wrong.
    """
    return {
        name: {
            "confident": share(sum(a.confident for a in part), len(part)),
            "correct": share(sum(a.correct for a in part if a.confident),
                             sum(a.confident for a in part)),
        }
        for name, part in {
            "known_classes": known, "other_kinds": other, "all": [*known, *other]
        }.items()
    }  # fmt: skip


def probability_bins(known: Answers) -> list[dict[str, Any]]:
    """Accuracy of answers by their probability."""
    return [
        {
            "above": low,
            "up_to": high,
            **share(sum(answer.correct for answer in held), len(held)),
            "mean_probability": _mean(answer.probability for answer in held),
        }
        for low, high, held in _binned(known)
    ]


def calibration_error(known: Answers) -> float | None:
    """Expected calibration error over `BIN_EDGES`, see `Reliability.expected_error`."""
    gaps = [
        abs(sum(answer.correct for answer in held) - sum(answer.probability for answer in held))
        for _, _, held in _binned(known)
    ]
    return sum(gaps) / len(known) if known else None


def _binned(known: Answers) -> list[tuple[float, float, list[CropAnswer]]]:
    """Lower edge, upper edge and the answers between; rounding above 1 counts as 1."""
    return [
        (low, high, [answer for answer in known if low < min(answer.probability, 1.0) <= high])
        for low, high in pairwise(BIN_EDGES)
    ]


def open_set_of(known: Answers, other: Answers) -> dict[str, Any]:
    """Separation of known classes and other kinds.

    `auroc` is None, with the `reason`, if one of them is missing.
    """
    measure, scores = open_set_scores([*known, *other])
    result: dict[str, Any] = {
        "measure": measure,
        "auroc": None,
        "reason": _why_no_curve(known, other, measure),
        "known_in_distribution": share(sum(a.in_distribution for a in known), len(known)),
        "other_in_distribution": share(sum(a.in_distribution for a in other), len(other)),
    }
    if not result["reason"]:
        separated = np.array(scores[: len(known)]), np.array(scores[len(known) :])
        result["auroc"] = area_under_curve(*separated)
    return result


def open_set_scores(answers: Answers) -> tuple[str, list[float]]:
    """The classifier's score for known classes; larger is more likely.

    Returns:
        Name of the measure, empty without one, and a score per answer.
    """
    belongs = [answer.in_distribution_probability for answer in answers]
    near = [answer.distance for answer in answers]
    if answers and None not in belongs:
        return "in_distribution_probability", [score for score in belongs if score is not None]
    if answers and None not in near:
        return "distance", [-score for score in near if score is not None]
    return "", []


def _why_no_curve(known: Answers, other: Answers, measure: str) -> str:
    if not other:
        return "there are no objects of other kinds"
    if not known:
        return "there are no objects of known classes"
    return "" if measure else "the classifier has no open-set measure"
