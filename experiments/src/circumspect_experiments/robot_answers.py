"""The robot's own set, and answers for scans from several starts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier
from circumspect.classification.model_description import OBJECTS
from circumspect.datasets import ObjectSet
from circumspect.datasets.gathered_set import read_gathered, read_manifest, read_training
from circumspect.errors import InputError
from circumspect.evaluation.accuracy import confusion_matrix
from circumspect.evaluation.yaw_sweep import YawSweep
from circumspect.gathering.object_selection import object_name
from circumspect.grid import OccupancyGrid
from circumspect.training import TrainingSettings
from circumspect.training.training_data import fitted_and_held_back
from circumspect_experiments.whole_set import ANGLES_DEG


@dataclass(frozen=True, eq=False)
class RobotScans:
    """Training scans, and test scans of other objects.

    Attributes:
        train: The scan of each object from its first start.
        tests: Test scans by the azimuth of the start [degrees], including those of the paper.
        grids: Name of a scan to the file of its grid.
    """

    train: ObjectSet
    tests: dict[float, ObjectSet]
    grids: dict[str, Path]

    @classmethod
    def read(cls, gathered: Path) -> RobotScans:
        """Read a gathered set and check that it is complete.

        Args:
            gathered: Folder of a set with the paper's starts, 0°, 45°, 90° and 135°.

        Raises:
            InputError: It can not be read, or a start, a split or scans to hold back are missing.
        """
        scans = read_manifest(gathered)
        starts = sorted({
            scan.start_deg for scan in scans if scan.split == "test" and scan.start_deg is not None
        })  # fmt: skip
        lacking = [f"{start:g}°" for start in ANGLES_DEG if start not in starts]
        if lacking:
            raise InputError(f"{gathered}: holds no test scans from {', '.join(lacking)}")
        train = read_training(gathered)
        try:
            fitted_and_held_back(train, TrainingSettings())
        except InputError as error:
            raise InputError(f"{gathered}: {error}") from error
        tests = {start: read_gathered(gathered, "test", [start]) for start in starts}
        grids = {scan.scan: gathered / scan.files["grid"] for scan in scans if "grid" in scan.files}
        return cls(train, tests, grids)


@dataclass(frozen=True, eq=False)
class StartAnswers:
    """Answers by the azimuth of the start [degrees].

    Attributes:
        labels: Start to (n,) true classes of its scans.
        answers: Start to (n,) answers; the number of classes stands for any other class.
        objects: Start to (n,) names of the objects.
        classes: The c class names.
    """

    labels: Mapping[float, NDArray[np.int64]]
    answers: Mapping[float, NDArray[np.int64]]
    objects: Mapping[float, NDArray[np.str_]]
    classes: tuple[str, ...]

    @classmethod
    def of_sweeps(cls, sweeps: Mapping[float, YawSweep], tests: Mapping[float, ObjectSet]) -> Self:
        """Answers of a network for the scans from each start at yaw 0."""
        return cls(
            {start: sweep.labels for start, sweep in sweeps.items()},
            {start: sweep.answers[0] for start, sweep in sweeps.items()},
            {start: tests[start].shown for start in sweeps},
            next(iter(tests.values())).classes,
        )

    @property
    def accuracy(self) -> dict[float, float]:
        """Start to the fraction of correct answers."""
        return {
            start: float((answers == self.labels[start]).mean())
            for start, answers in self.answers.items()
        }

    @property
    def changes(self) -> float:
        """Fraction of the objects whose label differs between starts; NaN without any.

        Objects with scans from only some of the starts do not count.
        """
        found: dict[str, list[int]] = defaultdict(list)
        for start, answers in self.answers.items():
            for name, answer in zip(self.objects[start].tolist(), answers.tolist(), strict=True):
                found[name].append(answer)
        whole = [answers for answers in found.values() if len(answers) == len(self.answers)]
        return float(np.mean([len(set(a)) > 1 for a in whole])) if whole else float("nan")

    def confusion(self, starts: Sequence[float]) -> NDArray[np.int64]:
        """(c + 1, c + 1) counts over some starts; row is the true class, the last any other."""
        labels = np.concatenate([self.labels[start] for start in starts])
        answers = np.concatenate([self.answers[start] for start in starts])
        return confusion_matrix(labels, answers, len(self.classes) + 1)

    def to_dict(self) -> dict[str, Any]:
        """Accuracy from each start, its mean and its worst, and label changes."""
        accuracy = self.accuracy
        return {
            "accuracy": {f"{start:g}": value for start, value in accuracy.items()},
            "mean": float(np.mean(list(accuracy.values()))),
            "worst": min(accuracy.values()),
            "changes": self.changes,
        }


def robot_answers(
    scans: RobotScans, progress: Callable[[int, int], None] | None = None
) -> tuple[StartAnswers, int]:
    """Classify the grids of all test scans, which contain free space and have bounds in metres.

    Args:
        scans: The set.
        progress: Called with (done, all).

    Returns:
        The answers, and the number of scans left out because the classifier was trained on their
        objects.

    Raises:
        InputError: A grid is missing or broken.
    """
    classifier = Classifier.load("robot")
    fitted = {object_name(name) for name in classifier.training.get(OBJECTS) or []}
    total = sum(len(test) for test in scans.tests.values())
    done = left_out = 0
    labels, answers, objects = {}, {}, {}
    for start, test in scans.tests.items():
        chosen, found = [], []
        for index, (name, shown) in enumerate(zip(test.names, test.shown, strict=True)):
            done += 1
            if shown in fitted:
                left_out += 1
                continue
            grid = OccupancyGrid.load(scans.grids[str(name)])
            label = classifier.classify_grid(grid, metric=True).label
            known = label in test.classes
            found.append(test.classes.index(label) if known else len(test.classes))
            chosen.append(index)
            if progress is not None:
                progress(done, total)
        labels[start] = test.labels[chosen]
        answers[start] = np.array(found, np.int64)
        objects[start] = test.shown[chosen]
    return StartAnswers(
        labels, answers, objects, next(iter(scans.tests.values())).classes
    ), left_out
