"""Cost and accuracy over yaw of the paper's network, others and the shipped classifier."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect import __version__
from circumspect.classification import Classifier, OnnxClassifier, Prediction
from circumspect.classification.upright import CLOSE, WayUp, poses_to_try, ranked, stood
from circumspect.datasets import GridCache, ObjectSet
from circumspect.evaluation.figures import save_figure
from circumspect.evaluation.markdown import table
from circumspect.evaluation.predictor import Predictor, load_predictor
from circumspect.evaluation.yaw_sweep import YawSweep, spread_yaws
from circumspect.export import export_onnx
from circumspect.nets import Checkpoint, build_net, cost_of
from circumspect.nets.registry import net_spec
from circumspect.storage import write_json
from circumspect_experiments.comparison_figures import draw_accuracies_over_yaw
from circumspect_experiments.contenders import (
    OURS,
    Comparison,
    Contender,
    label_of,
    trained_contenders,
)
from circumspect_experiments.stages import (
    RESULT,
    Watched,
    done_once,
    file_digest,
    is_measured,
    is_stored,
    measured,
    write_report,
)
from circumspect_experiments.training_record import training_table

WHOLE_DEG = (45.0, 90.0, 135.0)
"""Multiples of a whole cell (a 32nd of a turn), at which wrapped networks are invariant."""
ROUNDS = 15
WAYS = ("tumbled", "stood_up")
TUMBLED = "any_way_up"
"""Folder of the measurement on tumbled objects."""
RANDOM_YAW = (
    "Rows `trained at random yaw` saw every training object turned about the vertical at random, "
    "as in the papers of VoxNet, 3DShapeNets and PointNet; the others saw 0° alone. What the first "
    "keep over a turn is learnt; what the others keep is built in.\n\n"
)
MAX_NAME_LENGTH = 200
"""Maximum length of the name of a folder [characters]."""


def reproduce_rivals(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Train networks, and measure them and the shipped classifier at all yaws and in any pose.

    They train at 0° alone, except for the rows "trained at random yaw". Finished stages in the
    folder are kept. If `how` requests some rows only, the table holds these and every other
    finished one.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split.
        how: Settings.
        folder: For the runs, `rivals.md`, `rivals.json` and the figure.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `rivals.json`.

    Raises:
        WeightsError: The shipped classifier has other classes than the set.
        InputError: The folder contains results of another experiment.
        OutputError: It can not be written.
    """
    weights, records = trained_contenders(train, test, how, folder, watched, cache)
    weights = {
        net: path
        for net, path in weights.items()
        if how.asks_for(net) or _is_measured(path, test, how, folder / net)
    }
    rows, around = {}, {}
    for net, path in weights.items():
        row, around[label_of(net)] = _measured(net, path, test, how, folder / net, watched)
        rows[net] = row
    times = _timed(weights, test, folder)
    for net, row in rows.items():
        row["milliseconds"] = times[net]
        if net in records:
            row["training"] = records[net]
    figure = draw_accuracies_over_yaw(around, _trained_at(rows))
    save_figure(figure, folder / "rivals_over_yaw.png")
    how = how.of_rows(rows)
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
    for name, yaws in _sweeps(how).items():
        with watched.measuring(f"{net}, {name}") as progress:
            sweeps[name] = measured(weights, test, yaws, folder / name, progress)
    made_of = _tumbled_made_of(weights, test, how)

    def tumbled() -> dict[str, Any]:
        with watched.measuring(f"{net}, any way up") as progress:
            return _any_way_up(load_predictor(weights), test, how.seed, progress)

    around = sweeps["around"]
    row = {
        **_cost(net, weights, test),
        "at_0": float(around.accuracy[0]),
        **around.summary,
        "whole_cells": float(sweeps["whole"].accuracy.mean()),
        "whole_cells_flip_rate": sweeps["whole"].flip_rate,
        **done_once(folder / TUMBLED, made_of, tumbled, dict.fromkeys(WAYS, float)),
    }
    return row, around


def _is_measured(weights: Path, test: ObjectSet, how: Comparison, folder: Path) -> bool:
    """Whether all results of a row exist."""
    return is_stored(folder / TUMBLED, _tumbled_made_of(weights, test, how)) and all(
        is_measured(weights, test, yaws, folder / name) for name, yaws in _sweeps(how).items()
    )


def _sweeps(how: Comparison) -> dict[str, list[float]]:
    """The yaws [°] of each sweep by its name."""
    return {"around": list(spread_yaws(how.yaw_count)), "whole": list(WHOLE_DEG)}


def _tumbled_made_of(weights: Path, test: ObjectSet, how: Comparison) -> dict[str, Any]:
    return {
        "weights": file_digest(weights), "data": test.digest, "seed": how.seed, "close": CLOSE,
    }  # fmt: skip


def _cost(net: str, weights: Path, test: ObjectSet) -> dict[str, int]:
    """Cost of a row's network; for the shipped classifier that of the exported network."""
    spec = net_spec("planes") if net == OURS else Contender.from_name(net).spec
    cost = cost_of(
        build_net(spec.name, len(test.classes), spec.input_spec), spec.input_spec.input_shape
    )
    views = load_predictor(weights).input_spec.azimuth_views
    return {"parameters": cost.parameters, "multiply_adds": cost.multiply_adds * views}


def _any_way_up(
    predictor: Predictor, test: ObjectSet, seed: int, progress: Callable[[int, int], None]
) -> dict[str, float]:
    """Accuracy on objects turned at random about all axes.

    Returns:
        "tumbled": without correction; "stood_up": in the most probable pose, see `ranked`.
    """
    rng = np.random.default_rng(seed)
    right = np.zeros(2)
    for index, label in enumerate(test.labels):
        cloud = stood(test.cloud(index), Rotation.random(rng=rng))
        poses = poses_to_try(cloud)
        inputs = np.concatenate([predictor.input_spec.inputs(stood(cloud, pose)) for pose in poses])
        ways = [
            WayUp(Prediction.from_probabilities(test.classes, found), pose, number == 0)
            for number, (pose, found) in enumerate(
                zip(poses, predictor.probabilities(inputs), strict=True)
            )
        ]
        labels = [way.prediction.label for way in (ways[0], ranked(ways)[0])]
        right += np.array(labels) == test.classes[label]
        progress(index + 1, len(test))
    return dict(zip(WAYS, (right / len(test)).tolist(), strict=True))


def _timed(weights: dict[str, Path], test: ObjectSet, folder: Path) -> dict[str, float]:
    """Median time of a network on one object in ONNX Runtime on one thread, all in one run."""
    made_of = {"weights": {net: file_digest(path) for net, path in weights.items()}}

    def run() -> dict[str, float]:
        networks = {net: _in_onnx(net, path, folder) for net, path in weights.items()}
        return _timed_in_turns(networks, test)

    # A comparison with other networks is a separate measurement.
    at = folder / "times" / _file_name("+".join(weights))
    return done_once(at, made_of, run, dict.fromkeys(weights, float))


def _file_name(text: str) -> str:
    """The text, or a digest of it if it is longer than file names may be."""
    if len(text) <= MAX_NAME_LENGTH:
        return text
    return hashlib.sha256(text.encode()).hexdigest()


def _in_onnx(net: str, weights: Path, folder: Path) -> OnnxClassifier:
    """A network's ONNX file, converted once, and again if it is missing."""
    if net == OURS:
        return Classifier.load(weights, threads=1)
    path, stage = folder / net / "net.onnx", folder / net / "converted"

    def convert() -> str:
        export_onnx([Checkpoint.load(weights)], path)
        return file_digest(path)

    converted = done_once(stage, {"weights": file_digest(weights)}, convert, str)
    if not path.is_file() or file_digest(path) != converted:
        write_json(stage / RESULT, convert())
    return Classifier.load(path, threads=1)


def _timed_in_turns(networks: dict[str, OnnxClassifier], test: ObjectSet) -> dict[str, float]:
    """Time the networks alternately, so that other load on the machine affects all equally."""
    inputs: dict[str, NDArray[Any]] = {
        net: classifier.input_spec.inputs(test.cloud(0)) for net, classifier in networks.items()
    }
    spent: dict[str, list[float]] = {net: [] for net in networks}
    for _ in range(ROUNDS):
        for net, classifier in networks.items():
            start = time.perf_counter()
            classifier.probabilities(inputs[net])
            spent[net].append(1e3 * (time.perf_counter() - start))
    return {net: float(np.median(times[1:])) for net, times in spent.items()}


def _random_yaws(rows: Iterable[str]) -> set[bool]:
    """Whether rows are trained at random yaw, as a set of one or both values."""
    return {row != OURS and Contender.from_name(row).random_yaw for row in rows}


def _trained_at(rows: Iterable[str]) -> str:
    """The yaws at which the networks of a table were trained."""
    found = _random_yaws(rows)
    if found == {True}:
        return "trained at random yaw"
    others = "unless the name says otherwise" if True in found else "alone"
    return f"trained at 0° {others}"


def _markdown(document: dict[str, Any]) -> str:
    head = [
        "network", "weights", "mult-adds", "ms", "at 0°", "mean", "worst", "spread", "flips",
        "whole cells", "their flips", "tumbled", "stood up",
    ]  # fmt: skip
    rows = [
        [
            label_of(net),
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
    nets = document["nets"]
    records = {label_of(net): row["training"] for net, row in nets.items() if "training" in row}
    random_yaw = True in _random_yaws(nets)
    return (
        f"# Networks on ModelNet10, {_trained_at(nets)}\n\n"
        f"`{document['command']}`\n\n"
        + (RANDOM_YAW if random_yaw else "")
        + f"{document['objects']} test objects; mean, worst, spread and the share of objects whose "
        f"label changes are over {document['yaws']} yaws, each at another fraction of a cell. "
        "Whole cells: 45°, 90° and 135°, with the share of objects whose label changes between "
        "these. Tumbled: turned at random about all axes; stood up: the same, `--up auto`. "
        "Milliseconds: the network alone on one object (ours: all its views) in ONNX Runtime on "
        f"one thread, median, all in one run. `{OURS}` is the shipped classifier in eight "
        "bits.\n\n"
        + table(head, rows)
        + "\n\n"
        + training_table(list(records), list(records.values()), random_yaw)
        + "\n![Accuracy over all yaws](rivals_over_yaw.png)\n"
    )
