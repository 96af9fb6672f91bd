"""The paper's network, its rivals and ours: what they cost, and what a turn does to them."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect import __version__
from circumspect.classification import Classifier, OnnxClassifier
from circumspect.classification.upright import stood
from circumspect.datasets import GridCache, ObjectSet
from circumspect.evaluation.figures import save_figure
from circumspect.evaluation.markdown import table
from circumspect.evaluation.predictor import Predictor, load_predictor
from circumspect.evaluation.yaw_sweep import YawSweep, spread_yaws
from circumspect.export import export_onnx
from circumspect.geometry.resting_poses import resting_poses
from circumspect.nets import Checkpoint, build_net, cost_of
from circumspect.nets.registry import net_spec
from circumspect.reproduction.comparison_figures import draw_accuracies_over_yaw
from circumspect.reproduction.contenders import OURS, Comparison, trained_contenders
from circumspect.reproduction.stages import (
    done_once,
    file_digest,
    measured,
    write_report,
)
from circumspect.reproduction.training_record import training_table
from circumspect.reproduction.watched import Watched

WHOLE_DEG = (45.0, 90.0, 135.0)
"""Whole cells of a 32nd of a turn: to what wraps all of them look the same."""
ROUNDS = 15
WAYS = ("tumbled", "stood_up")


def reproduce_rivals(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Train the rivals at 0° and measure them and ours at all yaws, and any way up.

    Every stage whose result is in the folder is left as it is.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split.
        how: Settings.
        folder: For the runs, `rivals.md`, `rivals.json` and the figure.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        What `rivals.json` holds.

    Raises:
        WeightsError: The shipped classifier knows other classes than the set.
        InputError: The folder holds results of another experiment.
        OutputError: It can not be written.
    """
    weights, records = trained_contenders(train, test, how, folder, watched, cache)
    rows, around = {}, {}
    for net, path in weights.items():
        row, around[net] = _measured(net, path, test, how, folder / net, watched)
        rows[net] = row
    times = _timed(weights, test, folder)
    for net, row in rows.items():
        row["milliseconds"] = times[net]
        if net in records:
            row["training"] = records[net]
    save_figure(draw_accuracies_over_yaw(around), folder / "rivals_over_yaw.png")
    document = {
        "circumspect": __version__, "command": how.command("rivals --data modelnet10"),
        "objects": len(test), "yaws": how.yaw_count, "precision": how.precisions,
        "seed": how.seed, "nets": rows,
    }  # fmt: skip
    write_report(document, _markdown(document), folder, "rivals")
    return document


def _measured(
    net: str, weights: Path, test: ObjectSet, how: Comparison, folder: Path, watched: Watched
) -> tuple[dict[str, Any], YawSweep]:
    """The row of a network, without its time."""
    sweeps = {}
    for name, yaws in {"around": spread_yaws(how.yaw_count), "whole": WHOLE_DEG}.items():
        with watched.measuring(f"{net}, {name}") as progress:
            sweeps[name] = measured(weights, test, list(yaws), folder / name, progress)
    made_of = {"weights": file_digest(weights), "data": test.digest, "seed": how.seed}

    def tumbled() -> dict[str, Any]:
        with watched.measuring(f"{net}, any way up") as progress:
            return _any_way_up(load_predictor(weights), test, how.seed, progress)

    around = sweeps["around"]
    row = {
        **_cost(net, weights, test),
        "at_0": float(around.accuracy[0]),
        "mean": float(around.accuracy.mean()),
        "worst": float(around.accuracy.min()),
        "spread": float(np.ptp(around.accuracy)),
        "flip_rate": around.flip_rate,
        "whole_cells": float(sweeps["whole"].accuracy.mean()),
        "whole_cells_flip_rate": sweeps["whole"].flip_rate,
        **done_once(folder / "any_way_up", made_of, tumbled, dict.fromkeys(WAYS, float)),
    }
    return row, around


def _cost(net: str, weights: Path, test: ObjectSet) -> dict[str, int]:
    """Of the shipped classifier that of the network which it was exported from."""
    spec = net_spec("planes" if net == OURS else net)
    cost = cost_of(build_net(spec.name, len(test.classes), spec.recipe), spec.recipe.input_shape)
    views = load_predictor(weights).recipe.azimuth_views
    return {"parameters": cost.parameters, "multiply_adds": cost.multiply_adds * views}


def _any_way_up(
    predictor: Predictor, test: ObjectSet, seed: int, progress: Callable[[int, int], None]
) -> dict[str, float]:
    """Accuracy on objects that are turned at random about all axes.

    Returns:
        "tumbled": As they lie. "stood_up": Stood on each face that they can stand on, the surest
        answer counting.
    """
    rng = np.random.default_rng(seed)
    right = np.zeros(2)
    for index, label in enumerate(test.labels):
        cloud = stood(test.cloud(index), Rotation.random(rng=rng))
        clouds = [cloud, *(stood(cloud, pose) for pose in resting_poses(cloud))]
        inputs = np.concatenate([predictor.recipe.inputs(one) for one in clouds])
        found = predictor.probabilities(inputs)
        surest = 1 + found[1:].max(axis=1).argmax() if len(found) > 1 else 0
        right += found[[0, surest]].argmax(axis=1) == label
        progress(index + 1, len(test))
    return dict(zip(WAYS, (right / len(test)).tolist(), strict=True))


def _timed(weights: dict[str, Path], test: ObjectSet, folder: Path) -> dict[str, float]:
    """Median time of a network on one object in ONNX Runtime on one thread, all in one run."""
    made_of = {"weights": {net: file_digest(path) for net, path in weights.items()}}

    def run() -> dict[str, float]:
        networks = {net: _in_onnx(net, path, folder) for net, path in weights.items()}
        return _raced(networks, test)

    # Other networks make another race.
    at = folder / "times" / "+".join(weights)
    return done_once(at, made_of, run, dict.fromkeys(weights, float))


def _in_onnx(net: str, weights: Path, folder: Path) -> OnnxClassifier:
    path = weights
    if net != OURS:
        path = folder / net / "net.onnx"
        export_onnx([Checkpoint.load(weights)], path)
    return Classifier.load(path, threads=1)


def _raced(networks: dict[str, OnnxClassifier], test: ObjectSet) -> dict[str, float]:
    """In turns, so that what else the machine does meets all alike."""
    inputs: dict[str, NDArray[Any]] = {
        net: classifier.recipe.inputs(test.cloud(0)) for net, classifier in networks.items()
    }
    spent: dict[str, list[float]] = {net: [] for net in networks}
    for _ in range(ROUNDS):
        for net, classifier in networks.items():
            start = time.perf_counter()
            classifier.probabilities(inputs[net])
            spent[net].append(1e3 * (time.perf_counter() - start))
    return {net: float(np.median(times[1:])) for net, times in spent.items()}


def _markdown(document: dict[str, Any]) -> str:
    head = [
        "network", "weights", "mult-adds", "ms", "at 0°", "mean", "worst", "spread", "flips",
        "whole cells", "their flips", "tumbled", "stood up",
    ]  # fmt: skip
    rows = [
        [
            net,
            f"{row['parameters'] / 1e6:.2f} M",
            f"{row['multiply_adds'] / 1e6:,.0f} M",
            f"{row['milliseconds']:.1f}",
            *(f"{row[key]:.3f}" for key in ("at_0", "mean", "worst", "spread")),
            f"{row['flip_rate']:.1%}",
            f"{row['whole_cells']:.3f}",
            f"{row['whole_cells_flip_rate']:.1%}",
            *(f"{row[key]:.3f}" for key in ("tumbled", "stood_up")),
        ]
        for net, row in document["nets"].items()
    ]
    records = {net: row["training"] for net, row in document["nets"].items() if "training" in row}
    return (
        "# Networks on ModelNet10, trained at 0° alone\n\n"
        f"`{document['command']}`\n\n"
        f"{document['objects']} test objects; mean, worst, spread and the share of objects whose "
        f"label changes are over {document['yaws']} yaws, each at another fraction of a cell. "
        "Whole cells: 45°, 90° and 135°, with the share of objects whose label changes between "
        "these. Tumbled: turned at random about all axes; stood up: the same, `--up auto`. "
        "Milliseconds: the network alone on one object (ours: all its views) in ONNX Runtime on "
        f"one thread, median, all in one run. `{OURS}` is the shipped classifier in eight "
        "bits.\n\n"
        + table(head, rows)
        + "\n\n"
        + training_table(list(records), list(records.values()))
        + "\n![Accuracy over all yaws](rivals_over_yaw.png)\n"
    )
