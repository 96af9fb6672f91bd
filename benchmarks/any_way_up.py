"""Classification of objects whose upward direction is unknown.

    python -m benchmarks.any_way_up ModelNet10                 # selects `CLOSE`; ten minutes
    python -m benchmarks.any_way_up ModelNet10 --split test    # evaluates the selected value

The bound `CLOSE` of `circumspect.classification.upright` is selected on objects that were held back
from the training of `robot`; half of the inputs are upright and half are turned. The test objects
are used only for the report.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.provenance import provenance
from benchmarks.report import RESULTS, progress_report, write_page
from circumspect.classification import Classifier
from circumspect.classification.shipped import ROBOT
from circumspect.classification.upright import (
    CLOSE,
    WayUp,
    best_answer,
    stood,
    ways_up,
    without_floor,
)
from circumspect.datasets import ObjectSet
from circumspect.evaluation.evaluation_set import open_evaluation_set
from circumspect.evaluation.markdown import table
from circumspect.evaluation.predictor import load_predictor
from circumspect.geometry import PointCloud

COMMAND = "python -m benchmarks.any_way_up ModelNet10"
UPRIGHT, TURNED, FLOOR = "upright", "turned", "turned, with floor"
BOUNDS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0)
SAME_UP = np.cos(np.deg2rad(10.0))
FLOOR_REACH = 1.6
"""Radius of the floor, in multiples of the object's radius."""

_CASES = (
    "Turned: by 90°, 180° or 270° about x or y, at random. With floor: the turned object on a disc "
    f"of floor with {FLOOR_REACH:g} times its radius and as many points."
)


@dataclass(frozen=True)
class PoseTrial:
    """The answers for an object in a case.

    Attributes:
        case: Upright, turned, or turned with floor.
        label: True class.
        turn: Rotation from the standing object to the cloud.
        ways: The answers for all poses.
        floorless: See `without_floor`.
    """

    case: str
    label: str
    turn: Rotation
    ways: Sequence[WayUp]
    floorless: WayUp | None

    def outcome(self, close: float) -> dict[str, bool]:
        """Outcome of `--up auto` with a bound."""
        prediction, pose = best_answer(self.ways, self.floorless, close)
        correct = prediction.label == self.label
        return {
            "correct": correct,
            "stands": bool((pose * self.turn).as_matrix()[2, 2] > SAME_UP),
            "confident": prediction.confident,
            "confident_correct": prediction.confident and correct,
            "in_distribution": prediction.in_distribution,
            "correct_as_it_lies": self._as_it_lies == self.label,
        }

    @property
    def _as_it_lies(self) -> str:
        return next(way.prediction.label for way in self.ways if way.upright)


def main() -> int:
    """Measure and write a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="ModelNet10")
    parser.add_argument("--split", choices=("validation", "test"), default="validation")
    parser.add_argument("--every", type=int, default=1, help="use every N-th object")
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    made = provenance()
    found = open_evaluation_set(load_predictor(ROBOT), given.data, given.split)
    if found.seen:
        sys.exit(f"{ROBOT} was trained on some of these objects")
    # Objects are sorted by class, so that each class is thinned equally.
    objects = found.objects.subset(np.arange(len(found.objects)) % given.every == 0)
    trials = list(pose_trials(Classifier.load(ROBOT, threads=1), objects))
    count, thinned = len(objects), f" --every {given.every}" if given.every > 1 else ""
    about: dict[str, Any] = {"objects": count, "made": made}
    if given.split == "validation":
        rows = measured(trials, BOUNDS)
        write_page(
            "any_way_up_choice", "Any way up: the choice of the bound", COMMAND + thinned,
            choice_text(count, rows), {"rows": rows, "chosen": chosen(rows), **about}, given.out,
        )  # fmt: skip
        return 0
    rows = measured(trials, (CLOSE,))
    write_page(
        "any_way_up", "Any way up", f"{COMMAND} --split test{thinned}", test_text(count, rows),
        {"rows": rows, **about}, given.out,
    )  # fmt: skip
    return 0


def pose_trials(classifier: Classifier, objects: ObjectSet) -> Iterator[PoseTrial]:
    """Each object in each case, with a random rotation."""
    report = progress_report()
    for index, label in enumerate(objects.labels):
        rng = np.random.default_rng(index)
        cloud = objects.cloud(index)
        turn = quarter_turn(rng)
        for case, standing, turned in (
            (UPRIGHT, cloud, Rotation.identity()),
            (TURNED, cloud, turn),
            (FLOOR, with_floor(cloud, rng), turn),
        ):
            lying = stood(standing, turned)
            ways, floorless = ways_up(classifier, lying), without_floor(classifier, lying)
            yield PoseTrial(case, objects.classes[label], turned, ways, floorless)
        if index % 25 == 0:
            report(index, len(objects), str(objects.names[index]))


def quarter_turn(rng: np.random.Generator) -> Rotation:
    """A turn by 90°, 180° or 270° about x or y: the object lies or stands on its head."""
    axis, quarters = rng.integers(2), rng.integers(1, 4)
    return Rotation.from_euler("xy"[axis], 90.0 * quarters, degrees=True)


def with_floor(cloud: PointCloud, rng: np.random.Generator) -> PointCloud:
    """The object on a disc of floor with as many points as it has."""
    points = cloud.points_xyz
    reach = FLOOR_REACH * np.hypot(points[:, 0], points[:, 1]).max()
    angle = rng.uniform(0.0, 2.0 * np.pi, len(points))
    away = reach * np.sqrt(rng.random(len(points)))
    low = np.full(len(points), points[:, 2].min())
    disc = np.column_stack([away * np.cos(angle), away * np.sin(angle), low])
    return PointCloud(np.concatenate([points, disc]))


def measured(trials: Sequence[PoseTrial], bounds: Sequence[float]) -> list[dict[str, Any]]:
    """One row for each bound and case, with the share of objects for each outcome."""
    rows = []
    for close in bounds:
        for case in dict.fromkeys(one.case for one in trials):
            outcomes = [one.outcome(close) for one in trials if one.case == case]
            shares = {name: float(np.mean([one[name] for one in outcomes])) for name in outcomes[0]}
            rows.append({"close": close, "case": case, **shares})
    return rows


def accuracy(rows: Sequence[Mapping[str, Any]], close: float) -> float:
    """Share of correct labels if half of the files are upright and half are turned."""
    by_case = {row["case"]: row["correct"] for row in rows if row["close"] == close}
    return (by_case[UPRIGHT] + by_case[TURNED]) / 2


def chosen(rows: Sequence[Mapping[str, Any]]) -> float:
    """The bound with most correct labels; of equal ones the largest (more confident answers)."""
    return max((accuracy(rows, close), close) for close in {row["close"] for row in rows})[1]


def choice_text(count: int, rows: Sequence[Mapping[str, Any]]) -> str:
    """The page of the selection."""
    lines = []
    for close in dict.fromkeys(row["close"] for row in rows):
        upright, turned, floor = (row for row in rows if row["close"] == close)
        confident = upright["confident"] + turned["confident"]
        correct = upright["confident_correct"] + turned["confident_correct"]
        lines.append(
            [
                f"{close:g}",
                *(f"{row['correct']:.1%}" for row in (upright, turned)),
                f"{accuracy(rows, close):.1%}",
                f"{confident / 2:.1%}",
                f"{correct / confident:.1%}" if confident else "",
                f"{floor['confident'] - floor['confident_correct']:.1%}",
            ]
        )
    head = [
        "bound", "correct, upright", "correct, turned", "mean", "confident", "correct of these",
        "with floor: confident, incorrect",
    ]  # fmt: skip
    return (
        f"{count} objects of ModelNet10's training split that were held back from the training of "
        f"`{ROBOT}`, classified with `--up auto`, without a unit. {_CASES} Confident: share of the "
        "upright and the turned objects. The bound with the largest mean is selected: "
        f"**{chosen(rows):g}**. One object is {1 / count:.1%} of a column.\n\n" + table(head, lines)
    )


def test_text(count: int, rows: Sequence[Mapping[str, Any]]) -> str:
    """The page of the report."""
    names = ("correct_as_it_lies", "correct", "stands", "in_distribution", "confident")
    lines = [
        [
            row["case"],
            *(f"{row[name]:.1%}" for name in names),
            f"{row['confident_correct'] / row['confident']:.1%}" if row["confident"] else "",
        ]
        for row in rows
    ]
    head = [
        "shown", "correct without `--up`", "correct", "stands upright", "in distribution",
        "confident", "correct of these",
    ]  # fmt: skip
    return (
        f"{count} test objects of ModelNet10, classified by `{ROBOT}` with `--up auto`, without a "
        f"unit. The bound {CLOSE:g} was [selected](any_way_up_choice.md) on held-back objects. "
        f"{_CASES} Stands upright: the chosen pose is within 10° of the true one. An object that "
        "seems to contain a floor is not in distribution unless the file's pose has a confident "
        "answer; `--cut-floor` removes the floor.\n\n" + table(head, lines)
    )


if __name__ == "__main__":
    sys.exit(main())
