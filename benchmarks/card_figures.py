"""Figures for the model card of a shipped classifier, from the committed results.

python -m benchmarks.card_figures modelnet10            # writes weights/modelnet10.card.json
python -m benchmarks.card_figures modelnet10 --check    # fails if it is not up to date
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.report import RESULTS
from circumspect.classification.model_card import (
    NETWORK_TIME,
    SHARE,
    CardFigure,
    ModelCard,
    card_path,
)
from circumspect.classification.shipped import MODELNET10, ROBOT, shipped_path

EVALUATION = "circumspect evaluate --data ModelNet10 --split test --yaw-count 64"
THINNED = (128, 256, 1024)
"""Numbers of points of the thinned clouds in the card."""


def modelnet10_card() -> ModelCard:
    """The figures of `modelnet10`."""
    _, evaluated = _result("modelnet10_test/metrics.json")
    figures = (*_evaluated(), *_time(MODELNET10, 8), *_of_few_points(), *_lookalikes(), *_unknown())
    return ModelCard(evaluated["sha256"], figures)


def robot_card() -> ModelCard:
    """The figures of `robot`."""
    _, found = _result("real_objects/metrics.json")
    sha256 = found["sha256"]
    held_out = (*_left_out_rooms(sha256), *_turned(sha256))
    return ModelCard(sha256, (*_real_objects(), *held_out, *_time(ROBOT, 3)))


CARDS: dict[str, Callable[[], ModelCard]] = {MODELNET10: modelnet10_card, ROBOT: robot_card}
"""Shipped classifiers whose card is made from committed results."""


def _evaluated() -> tuple[CardFigure, ...]:
    source, found = _result("modelnet10_test/metrics.json")
    accuracy, by_class = found["accuracy"], found["mean_class_accuracy"]
    data, yaws = f"ModelNet10 test, {found['objects']} objects", f"{len(accuracy)} yaws"

    def figure(measure: str, value: float, unit: str = SHARE, headline: bool = False) -> CardFigure:
        return CardFigure(measure, value, unit, data, EVALUATION, source, headline)

    return (
        figure(f"accuracy, mean over {yaws}", _mean(accuracy), headline=True),
        figure(f"accuracy, worst of {yaws}", min(accuracy)),
        figure(f"accuracy, best of {yaws}", max(accuracy)),
        figure(f"mean-class accuracy, mean over {yaws}", _mean(by_class)),
        figure(f"objects whose label changes over {yaws}", found["flip_rate"]),
        figure("expected calibration error", found["expected_calibration_error"], ""),
    )


def _real_objects() -> tuple[CardFigure, ...]:
    """Figures on labelled real objects of development sets outside the repository."""
    source, found = _result("real_objects/metrics.json")
    command, known = found["command"], found["objects"]["known_classes"]
    names = {"objects": "SUN3D, single Xtion views", "sunrgbd": "SUN RGB-D, single views"}
    names["scannet"] = "ScanNet, fused scans"
    every = f"real objects of the ten classes, {known}"

    def figure(
        measure: str, value: float, data: str, unit: str = SHARE, headline: bool = False
    ) -> CardFigure:
        return CardFigure(measure, value, unit, data, command, source, headline)

    confident = found["confident"]["known_classes"]
    open_set = found["open_set"]
    others = found["objects"]["other_kinds"]
    figures = [figure("accuracy", found["overall"]["accuracy"]["share"], every, headline=True)]
    figures += [
        figure("accuracy", one["share"], f"{names[name]}, {one['objects']}")
        for name, one in found["per_source"].items()
    ]
    figures += [
        figure("class among best 2", found["overall"]["top_2"]["share"], every),
        figure("mean accuracy per class", found["overall"]["mean_class_accuracy"], every),
        figure("confident answers", confident["confident"]["share"], every),
        figure("accuracy of confident answers", confident["correct"]["share"], every),
        figure("expected calibration error", found["expected_calibration_error"], every, ""),
        figure(
            "open set, area under the ROC curve", open_set["auroc"],
            f"the same and {others} of other kinds", "",
        ),
    ]  # fmt: skip
    return tuple(figures)


def _left_out_rooms(sha256: str) -> tuple[CardFigure, ...]:
    """Confidence in rooms left out of the calibration; empty if not measured for this file."""
    source, found = _result("left_out_rooms.json")
    if found["sha256"] != sha256:
        return ()
    confident = int(found["confident"] + found["confident_other"])
    objects = int(found["known"] + found["other"])
    every = f"real objects of all kinds, {objects}; each room judged without it"
    return (
        CardFigure(
            "confident answers", confident / objects, SHARE, every, found["command"], source
        ),
        CardFigure(
            "accuracy of confident answers", found["correct_confident"] / confident, SHARE, every,
            found["command"], source,
        ),
    )  # fmt: skip


def _turned(sha256: str) -> tuple[CardFigure, ...]:
    """Accuracy on complete objects; empty if not measured for this file."""
    if not (RESULTS / "robot_modelnet10_test/metrics.json").is_file():
        return ()
    source, found = _result("robot_modelnet10_test/metrics.json")
    if found["sha256"] != sha256:
        return ()
    accuracy = found["accuracy"]
    data = f"ModelNet10 test, {found['objects']} objects, unknown scale"
    command = EVALUATION.replace("evaluate", "evaluate --model robot")
    return tuple(
        CardFigure(f"accuracy, {name} of {len(accuracy)} yaws", value, SHARE, data, command, source)
        for name, value in (("mean", _mean(accuracy)), ("worst", min(accuracy)))
    )


def _time(name: str, views: int) -> tuple[CardFigure, ...]:
    source, found = _result("classifier_speed.json")
    row = next(row for row in found["rows"] if row["name"] == f"{name}, {views} views, 1 thread")
    data = f"{views} grids, 1 thread of an {found['machine']['processor']}, median"
    return (CardFigure(NETWORK_TIME, row["median"], "ms", data, found["command"], source),)


def _of_few_points() -> tuple[CardFigure, ...]:
    source, found = _result("few_points.json")
    rows = [row for row in found["counts"] if row["points"] in THINNED]
    return tuple(
        CardFigure(measure, row[key], SHARE, data, found["command"], source)
        for row in rows
        for data in [f"ModelNet10 test at 0°, {row['points']:,} points an object"]
        for measure, key in (
            ("accuracy", "accuracy"),
            ("wrong answers among the objects not called unknown", "incorrect_of_near"),
        )
    )


def _lookalikes() -> tuple[CardFigure, ...]:
    source, found = _result("lookalikes.json")
    wrong = found["wrong"]
    measure = "wrong answers whose class has a training object of 90 % overlap"
    data = f"ModelNet10 test at 0°, {wrong['objects']} wrong answers"
    return (CardFigure(measure, wrong["class given"], SHARE, data, found["command"], source),)


def _unknown() -> tuple[CardFigure, ...]:
    source, found = _result("unknown/unknown.json")
    kinds = found["other_things"]["called_unknown"]
    left_out = [row["left_out_called_unknown"] for row in found["left_out"].values()]
    command = found["command"]
    return (
        CardFigure(
            "objects of other kinds called unknown", _mean(list(kinds.values())), SHARE,
            f"procedural objects of {len(kinds)} kinds, 4 grids each", command, source,
        ),
        CardFigure(
            "objects of a class left out of the training called unknown", _mean(left_out), SHARE,
            "ModelNet10 test, networks trained without each class", command, source,
        ),
    )  # fmt: skip


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


def _result(name: str) -> tuple[str, dict[str, Any]]:
    """Path of a result in the repository, and its content."""
    file = RESULTS / name
    place = file.relative_to(RESULTS.parents[1]).as_posix()
    return place, json.loads(file.read_text(encoding="utf-8"))


def is_current(name: str, beside: Path) -> bool:
    """Whether a card equals the committed results."""
    return beside.is_file() and ModelCard.load(beside) == CARDS[name]()


def main() -> int:
    """Write a card, or compare it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=sorted(CARDS))
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    beside = card_path(shipped_path(given.name))
    if given.check:
        return int(not is_current(given.name, beside))
    CARDS[given.name]().save(beside)
    return 0


if __name__ == "__main__":
    sys.exit(main())
