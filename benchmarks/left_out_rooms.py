"""Confidence of a classifier in rooms that were left out of its calibration.

    python -m benchmarks.left_out_rooms --data ModelNet10 --catalogue MESHES.npz --real CROPS.npz

Temperature and bounds are fitted without each room in turn and applied to it. The open-set test is
fitted without each file of real objects in turn.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import RESULTS, write_page
from circumspect.classification import Classifier, GridSpec, OnnxClassifier
from circumspect.classification.model_facts import ModelFacts
from circumspect.cli.commands.calibrate import calibration_objects, scan_augmentation
from circumspect.datasets.labelled_crops import read_labelled_crops
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.evaluation.accuracy import area_under_curve
from circumspect.evaluation.classifier_calibration import Answers, calibrate, judged, real_answers
from circumspect.evaluation.held_back_scans import held_back_scans
from circumspect.evaluation.markdown import table

SCANS = 2
"""Number of scans of each held-back object."""
COMMAND = "python -m benchmarks.left_out_rooms --data ModelNet10 --catalogue MESHES.npz --real {}"


def main() -> int:
    """Measure and write `left_out_rooms.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", default="robot", help="name or file of the classifier")
    parser.add_argument("--data", type=Path, required=True, help="ModelNet10")
    parser.add_argument("--catalogue", type=Path, nargs="*", default=[])
    parser.add_argument("--real", type=Path, nargs="+", required=True)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    classifier = Classifier.load(given.model)
    assert isinstance(classifier, OnnxClassifier)
    seen, files = simulated(classifier, given.data, given.catalogue)
    real, sources, rooms = real_objects(classifier, given.real)
    figures = measured(classifier, seen, files, real, sources, rooms)
    command = COMMAND.format(" ".join(path.name for path in given.real))
    write_page(
        "left_out_rooms",
        "Confidence in rooms left out",
        command,
        page_text(figures),
        {**figures, "sha256": ModelFacts.load(given.model).sha256},
        given.out,
    )
    return 0


def simulated(
    classifier: OnnxClassifier, data: Path, catalogues: Sequence[Path]
) -> tuple[Answers, Answers]:
    """Answers to held-back objects, with rays and without."""
    assert isinstance(classifier.input_spec, GridSpec)
    sources = calibration_objects(classifier, data, catalogues)
    scans = held_back_scans(sources, scan_augmentation(classifier), classifier.input_spec, SCANS)
    return (
        Answers.of(classifier, scans.with_rays()),
        Answers.of(classifier, scans.without_rays()),
    )


def real_objects(
    classifier: OnnxClassifier, paths: Sequence[Path]
) -> tuple[Answers, NDArray[np.str_], NDArray[np.str_]]:
    """Answers to real objects, with the file and the room of each object."""
    parts, sources, rooms = [], [], []
    for path in paths:
        crops = read_labelled_crops(path)
        answers, chosen = real_answers(classifier, crops)
        parts.append(answers)
        sources += [path.stem] * len(chosen)
        rooms += [f"{path.stem}/{room}" for room in crops.scenes[chosen].tolist()]
    return Answers.joined(parts), np.array(sources), np.array(rooms)


def measured(
    classifier: OnnxClassifier,
    seen: Answers,
    files: Answers,
    real: Answers,
    sources: NDArray[np.str_],
    rooms: NDArray[np.str_],
) -> dict[str, float]:
    """Figures of the page.

    Args:
        classifier: The classifier.
        seen: Answers to simulated scans.
        files: Answers to the same scans without rays.
        real: Answers to n real objects.
        sources: (n,) file of each object.
        rooms: (n,) room of each object.
    """
    confident, in_distribution = np.zeros(len(rooms), bool), np.zeros(len(rooms))
    bounds = []
    for left in _masks(rooms):
        found = calibrate(classifier, seen, files, real.subset(~left))
        factor = found.temperature / classifier.temperature
        bounds.append(found.confidence.without_coverage)
        confident[left] = judged(real.subset(left), factor, found.open_set) >= bounds[-1]
    for left in _masks(sources):
        others = real.subset(~left) if not left.all() else None
        found = calibrate(classifier, seen, files, others)
        if found.open_set is not None:
            part = real.subset(left)
            in_distribution[left] = found.open_set.probability(part.other, part.distance)
    known, correct = real.labels != OTHER, real.correct(classifier.classes)
    return {
        "rooms": float(len(bounds)),
        "known": float(known.sum()),
        "other": float((~known).sum()),
        "correct": float(correct[known].sum()),
        "confident": float((confident & known).sum()),
        "correct_confident": float((confident & correct).sum()),
        "confident_other": float((confident & ~known).sum()),
        "least_bound": min(bounds),
        "largest_bound": max(bounds),
        "open_set": area_under_curve(in_distribution[known], in_distribution[~known]),
    }


def page_text(found: dict[str, float]) -> str:
    """The page's text."""
    known, confident = int(found["known"]), int(found["confident"])
    rows = [
        ["rooms", str(int(found["rooms"]))],
        ["objects of known classes", str(known)],
        ["objects of other kinds", str(int(found["other"]))],
        ["correct answers", f"{int(found['correct'])} ({found['correct'] / known:.0%})"],
        ["confident answers to known classes", f"{confident} ({confident / known:.0%})"],
        ["correct ones among these", str(int(found["correct_confident"]))],
        ["confident answers to other kinds", str(int(found["confident_other"]))],
        ["bound on the probability", f"{found['least_bound']:.3f} to {found['largest_bound']:.3f}"],
        ["area under the ROC curve, open set", f"{found['open_set']:.3f}"],
    ]
    return (
        "The weights of the network do not depend on real objects, but the confidence does. Here "
        "the calibration excludes the room of each object, and the open-set test its file.\n\n"
        + table(["figure", "value"], rows)
    )


def _masks(groups: NDArray[np.str_]) -> Iterator[NDArray[np.bool_]]:
    """A mask for each group."""
    for group in np.unique(groups):
        yield groups == group


if __name__ == "__main__":
    sys.exit(main())
