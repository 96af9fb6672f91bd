"""Detection of objects of no known class."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from circumspect import __version__
from circumspect.classification import OnnxClassifier
from circumspect.classification.shipped import MODELNET10, shipped_path
from circumspect.datasets import GridCache, ObjectSet, validation_split
from circumspect.evaluation.accuracy import area_under_curve
from circumspect.evaluation.calibration import known_within
from circumspect.evaluation.distances import nearest_distances
from circumspect.evaluation.markdown import table
from circumspect.evaluation.yaw_sweep import spread_yaws
from circumspect.export import export_onnx
from circumspect.export.examples import example_table
from circumspect.export.nearest import write_with_distance
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.nets import Checkpoint
from circumspect.nets.registry import net_spec
from circumspect_experiments.experiment import Experiment
from circumspect_experiments.stages import (
    Watched,
    done_once,
    file_digest,
    measured,
    trained,
    write_report,
)
from circumspect_experiments.whole_set import require_shipped_classes

SAMPLES = 32768
"""Number of points sampled on each other thing, as `classify` does on a mesh. The holes between
fewer points would make any object look unknown."""
JUDGED = (
    "accuracy", "unknown_beyond", "known_called_known", "left_out_called_unknown",
    "area_under_curve",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Unknown(Experiment):
    """Settings of the experiment; see `Experiment`.

    Attributes:
        net: The network that is trained without each class in turn.
        each: Number of other things of each kind.
    """

    net: str = "planes"
    each: int = 20

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`."""
        return (self.net,)


def reproduce_unknown(
    train: ObjectSet,
    test: ObjectSet,
    how: Unknown,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Leave out each class in turn, and classify things of other kinds with all networks.

    An object is called unknown if it is farther from all training objects than 95 % of the
    held-back ones. Finished stages in the folder are kept.

    Args:
        train: The training split; part of it is held back.
        test: The test split.
        how: Settings.
        folder: For the runs, `unknown.md` and `unknown.json`.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `unknown.json`.

    Raises:
        WeightsError: The classifier `modelnet10` has other classes than the set.
        InputError: The set lacks classes of ModelNet10, or has others; or the folder holds results
            of another experiment.
        OutputError: It can not be written.
    """
    require_shipped_classes(train, test)
    settings = how.settings(how.net)
    # Ten sets are augmented; the number of variants is limited to what the epochs use.
    settings = replace(settings, replicas=min(settings.replicas, settings.epochs))
    input_spec = net_spec(how.net).input_spec
    rows: dict[str, Any] = {}
    for label, left_out in enumerate(train.classes):
        known, _ = without(train, label)
        at = folder / f"without-{left_out}"
        with watched.training(f"without {left_out}", settings.epochs) as observer:
            weights = trained(known, settings, input_spec, at / "training", observer, cache)
        rows[left_out] = done_once(
            at / "judged",
            {
                "weights": file_digest(weights), "train": train.digest, "test": test.digest,
                "yaw_count": how.yaw_count,
            },
            partial(_measured_without, weights, known, without(test, label), how, at, watched),
            dict.fromkeys(JUDGED, float),
        )  # fmt: skip
    document = {
        "circumspect": __version__, "command": how.command("unknown --data modelnet10"),
        "net": how.net, "epochs": settings.epochs,
        "yaws": how.yaw_count, "precision": how.precisions, "seed": how.seed,
        "left_out": rows, "other_things": _of_shipped(test.classes, how, folder, watched),
    }  # fmt: skip
    write_report(document, _markdown(document), folder, "unknown")
    return document


def without(objects: ObjectSet, label: int) -> tuple[ObjectSet, ObjectSet]:
    """Split a set into the objects of all classes but one, and those of that class.

    Returns:
        Two sets with the remaining classes; the labels of the second set are meaningless.
    """
    classes = objects.classes[:label] + objects.classes[label + 1 :]
    kept = objects.labels != label
    labels = objects.labels - (objects.labels > label)
    known = ObjectSet(objects.points_xyz[kept], labels[kept], objects.names[kept], classes)
    rest = ObjectSet(
        objects.points_xyz[~kept], np.zeros_like(labels[~kept]), objects.names[~kept], classes
    )
    return known, rest


def other_things(classes: tuple[str, ...], each: int, points: int) -> ObjectSet:
    """Make things of all other kinds; their labels are meaningless.

    Args:
        classes: Classes of the classifier.
        each: Number of things of every kind.
        points: Number of points of every thing.
    """
    made = [(kind, seed) for kind in OTHER_THINGS for seed in range(each)]
    clouds = [make_other_thing(*one).sampled(points, one[1]).points_xyz for one in made]
    names = np.array([f"{kind}_{seed:04d}" for kind, seed in made])
    return ObjectSet(np.array(clouds, np.float32), np.zeros(len(made), np.int64), names, classes)


def _measured_without(
    weights: Path,
    trained_on: ObjectSet,
    tested_on: tuple[ObjectSet, ObjectSet],
    how: Unknown,
    folder: Path,
    watched: Watched,
) -> dict[str, float]:
    """Measure a network that was trained without a class."""
    known, left_out = tested_on
    yaws = spread_yaws(how.yaw_count)
    with watched.measuring(f"{folder.name}, known") as progress:
        sweep = measured(weights, known, yaws, folder / "known", progress)
    with watched.measuring(f"{folder.name}, training objects") as progress:
        classifier = _with_training_objects(weights, trained_on, folder / "net.onnx", progress)
    held_back = trained_on.subset(validation_split(trained_on))
    threshold = known_within(nearest_distances(classifier, held_back, yaws[:1])[0])
    with watched.measuring(f"{folder.name}, distances") as progress:
        near = nearest_distances(classifier, known, yaws, progress)
    far = nearest_distances(classifier, left_out, yaws)
    return {
        "accuracy": float(sweep.accuracy.mean()),
        "unknown_beyond": threshold,
        "known_called_known": float((near <= threshold).mean()),
        "left_out_called_unknown": float((far > threshold).mean()),
        "area_under_curve": area_under_curve(-near.ravel(), -far.ravel()),
    }


def _with_training_objects(
    weights: Path, trained_on: ObjectSet, path: Path, progress: Callable[[int, int], None]
) -> OnnxClassifier:
    """Export the network as an ONNX file with its training objects."""
    export_onnx([Checkpoint.load(weights)], path)
    classifier = OnnxClassifier.load(path)
    write_with_distance(path, example_table(classifier, trained_on, progress), None)
    return OnnxClassifier.load(path)


def _of_shipped(
    classes: tuple[str, ...], how: Unknown, folder: Path, watched: Watched
) -> dict[str, Any]:
    """Fraction of other things that `modelnet10` calls unknown, by kind."""
    classifier = OnnxClassifier.load(MODELNET10)
    threshold = float(classifier.description["unknown_beyond"])
    things = other_things(classes, how.each, SAMPLES)
    made_of = {
        "weights": file_digest(shipped_path(MODELNET10)), "things": things.digest,
        "yaw_count": how.yaw_count,
    }  # fmt: skip

    def are_unknown() -> list[list[bool]]:
        with watched.measuring("other things") as progress:
            found = nearest_distances(classifier, things, spread_yaws(how.yaw_count), progress)
        return (found > threshold).tolist()

    form = [[bool] * len(things)] * how.yaw_count
    unknown = np.array(done_once(folder / "other_things", made_of, are_unknown, form))
    kinds = np.array([name.rsplit("_", 1)[0] for name in things.names])
    return {
        "unknown_beyond": threshold,
        "called_unknown": {kind: float(unknown[:, kinds == kind].mean()) for kind in OTHER_THINGS},
    }


def _markdown(document: dict[str, Any]) -> str:
    head = ["left out", "accuracy on the rest", "known called known", "left out called unknown"]
    keys = [key for key in JUDGED if key != "unknown_beyond"]
    rows = [
        [name.replace("_", " "), *(f"{row[key]:.3f}" for key in keys)]
        for name, row in document["left_out"].items()
    ]
    mean = [np.mean([row[key] for row in document["left_out"].values()]) for key in keys]
    rows.append(["mean", *(f"{value:.3f}" for value in mean)])
    other = document["other_things"]
    called = other["called_unknown"]
    shown = [[kind.replace("_", " "), f"{value:.2f}"] for kind, value in called.items()]
    shown.append(["mean", f"{np.mean(list(called.values())):.2f}"])
    return (
        "# Objects of no known class\n\n"
        f"`{document['command']}`\n\n"
        f"`{document['net']}` trained {document['epochs']} epochs without a class; what is "
        "farther from all that was trained on than 95 % of the held-back objects is called "
        "unknown. On ModelNet10's "
        f"test objects at {document['yaws']} yaws.\n\n"
        + table([*head, "area under ROC"], rows)
        + f"\n\nThe shipped classifier (beyond {other['unknown_beyond']:.3f}) on procedural "
        "things of other kinds:\n\n" + table(["kind", "called unknown"], shown) + "\n"
    )
