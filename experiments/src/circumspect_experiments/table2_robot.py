"""The half of the paper's Table 2 on the robot's own set."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from circumspect import __version__
from circumspect.classification import GridSpec
from circumspect.datasets import GridCache
from circumspect.evaluation.figures import draw_confusion, save_figure
from circumspect.evaluation.markdown import table
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect_experiments.robot_answers import RobotScans, StartAnswers, robot_answers
from circumspect_experiments.stages import Watched, measured, trained, write_report
from circumspect_experiments.table2 import NETS, OURS, Table2
from circumspect_experiments.training_record import training_record, training_table
from circumspect_experiments.whole_set import ANGLES_DEG, ROBOT

PAPERS_STARTS = "4 starts"
EPOCH_DRAWS = 3_400
"""Number of draws in an epoch on ModelNet10. An epoch on scans has about as many, so that both
halves of the table have the same schedule."""
SEEDS = 3
"""Number of trainings of the network that the paper proposes, and of our network."""
SEEDED = (("cylindrical", "rwmp"), None)
"""Rows that are trained with several seeds; None is our network."""
SHIPPED = "robot"
"""Name of the robot's classifier."""
OTHER = "another class"
"""Label for classes of the robot's classifier that the set does not have."""


def reproduce_robot(
    scans: RobotScans, how: Table2, folder: Path, watched: Watched, cache: GridCache | None = None
) -> dict[str, Any]:
    """Train on scans from the first start, and test on scans of other objects from every start.

    The rows are the four networks of the paper, our network, and the shipped classifier of the
    robot, which is not trained on the set. Clouds are not turned: each is in the map of its robot,
    whose origin is at the start.

    Args:
        scans: Training and test scans.
        how: Settings.
        folder: For the runs, `table2_robot.md`, `table2_robot.json` and the figures.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `table2_robot.json`.

    Raises:
        InputError: The folder holds results of another experiment.
        OutputError: It can not be written.
    """
    networks: list[tuple[str, str, str, GridSpec | None, tuple[str, str] | None]] = [
        (f"{kind}, {pool}", f"robot-{kind}-{pool}", NETS[pool], GridSpec(kind, how.shape),
         (kind, pool))
        for kind, pool in ROBOT
    ]  # fmt: skip
    networks.append((f"ours ({OURS})", f"robot-{OURS}", OURS, None, None))
    rows = []
    for title, name, net, input_spec, published in networks:
        found = [
            _tested(name, net, seed, scans, how, folder, watched, cache, input_spec)
            for seed in range(SEEDS if published in SEEDED else 1)
        ]
        _draw(found[0][0], folder / _confusions(title))
        rows.append(_row(title, found, None if published is None else ROBOT[published]))
    with watched.measuring("the robot's classifier") as progress:
        answers, left_out = robot_answers(scans, progress)
    _draw(answers, folder / _confusions(SHIPPED))
    rows.append({**_row(SHIPPED, [(answers, None)], None), "left_out": left_out})
    document = {
        "circumspect": __version__,
        "command": how.command("table2 --data modelnet10 --robot gathered"),
        "classes": list(scans.train.classes),
        "train_scans": len(scans.train),
        "test_scans": {f"{start:g}": len(objects) for start, objects in scans.tests.items()},
        "precision": how.precisions,
        "seed": how.seed,
        "rows": rows,
    }
    write_report(document, _markdown(document), folder, "table2_robot")
    return document


def _tested(
    name: str,
    net: str,
    seed: int,
    scans: RobotScans,
    how: Table2,
    folder: Path,
    watched: Watched,
    cache: GridCache | None,
    input_spec: GridSpec | None,
) -> tuple[StartAnswers, dict[str, float]]:
    """Answers of a network for the scans from every start, and the record of its training."""
    settings = with_equal_steps(how.settings(net), len(scans.train))
    settings = replace(settings, seed=how.seed + seed)
    name = f"{name}-{seed}" if seed else name
    with watched.training(name, settings.epochs) as observer:
        weights = trained(
            scans.train, settings, input_spec or net_spec(net).input_spec,
            folder / name / "training", observer, cache,
        )  # fmt: skip
    sweeps = {}
    for start, objects in scans.tests.items():
        with watched.measuring(f"{name} from {start:g}°") as progress:
            at = folder / name / f"start_{start:g}"
            sweeps[start] = measured(weights, objects, [0.0], at, progress)
    return StartAnswers.of_sweeps(sweeps, scans.tests), training_record(weights)


def with_equal_steps(defaults: TrainingSettings, count: int) -> TrainingSettings:
    """Training settings for a smaller set with as many steps as on ModelNet10.

    Args:
        defaults: Settings for ModelNet10.
        count: Number of training scans.
    """
    return replace(defaults, passes=max(1, round(EPOCH_DRAWS / count)))


def _draw(answers: StartAnswers, path: Path) -> None:
    """Draw the confusion matrix of all answers for scans from the paper's starts."""
    counts, classes = answers.confusion(ANGLES_DEG), [*answers.classes, OTHER]
    if not counts[:, -1].any():
        counts, classes = counts[:-1, :-1], classes[:-1]
    save_figure(draw_confusion(counts, classes, PAPERS_STARTS), path)


def _row(
    name: str,
    found: Sequence[tuple[StartAnswers, dict[str, float] | None]],
    published: tuple[float, ...] | None,
) -> dict[str, Any]:
    """A row with means over the seeds, and the result of each seed."""
    each = [answers.to_dict() for answers, _ in found]
    mean = {start: float(np.mean([e["accuracy"][start] for e in each]))
            for start in each[0]["accuracy"]}  # fmt: skip
    return {
        "network": name,
        "accuracy": mean,
        "paper": None if published is None else list(published),
        "mean": float(np.mean([e["mean"] for e in each])),
        "worst": float(np.mean([e["worst"] for e in each])),
        "changes": float(np.mean([e["changes"] for e in each])),
        "seeds": [
            {**one, "training": record} for one, (_, record) in zip(each, found, strict=True)
        ],
    }


def _markdown(document: dict[str, Any]) -> str:
    starts = list(document["test_scans"])
    paper = [f"{angle:g}" for angle in ANGLES_DEG]
    shown = [*paper, *(start for start in starts if start not in paper)]
    rows = []
    for row in document["rows"]:
        published = [*(row["paper"] or [])]
        published += [None] * (len(shown) - len(published))
        cells = [
            _accuracy(row, start, value) for start, value in zip(shown, published, strict=True)
        ]
        cells += [f"{row['mean']:.3f}", f"{row['worst']:.3f}", f"{row['changes']:.0%}"]
        rows.append([row["network"], *cells])
    head = ["network", *(f"{start}°" for start in shown), "mean", "worst", "changes"]
    trained_rows = [row for row in document["rows"] if row["seeds"][0]["training"]]
    names = [f"{row['network']}{f', seed {n}' if n else ''}"
             for row in trained_rows for n in range(len(row["seeds"]))]  # fmt: skip
    records = [seed["training"] for row in trained_rows for seed in row["seeds"]]
    return (
        f"# Table 2: the robot's own set\n\n`{document['command']}`\n\n"
        f"Accuracy on scans of test objects by the azimuth of their start, in brackets that of the "
        f"paper on its own set. {document['train_scans']} scans from the first start train, of "
        f"{len(document['classes'])} classes ({', '.join(document['classes'])}); "
        f"{document['test_scans'][paper[0]]} scans a start test. Each robot starts up to 10° "
        "askew, so that no start is a whole number of cells from another. Changes: objects that "
        "are not called the same from all starts. An epoch shows about as many scans as one on "
        f"ModelNet10 shows objects; {document['precision']}. Where {SEEDS} seeds are trained, "
        "figures are their means, and ± half of the range at a start. The robot's classifier "
        f"({SHIPPED}) ships with circumspect, is not trained on this set, names all ten classes "
        "of ModelNet10, and is shown free space and size, too; "
        f"{document['rows'][-1]['left_out']} scans of objects that it was trained on are left "
        "out.\n\n"
        + table(head, rows)
        + "\n\n"
        + training_table(names, records)
        + "".join(f"\n![Confusions, {row[0]}]({_confusions(row[0])})\n" for row in rows)
    )


def _accuracy(row: dict[str, Any], start: str, published: float | None) -> str:
    found = [seed["accuracy"][start] for seed in row["seeds"]]
    text = f"{row['accuracy'][start]:.3f}"
    if len(found) > 1:
        text += f" ± {np.ptp(found) / 2:.3f}"
    return text if published is None else f"{text} ({published:.2f})"


def _confusions(network: str) -> str:
    """File name of the figure."""
    return f"confusion_robot_{'_'.join(re.findall('[a-z]+', network))}.png"
