"""Table 2 of the paper, its half on the robot's own set."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from circumspect import __version__
from circumspect.classification import GridRecipe
from circumspect.datasets import GridCache
from circumspect.evaluation.figures import draw_confusion, save_figure
from circumspect.evaluation.markdown import table
from circumspect.nets.registry import net_spec
from circumspect.reproduction.published import ANGLES_DEG, ROBOT
from circumspect.reproduction.robot_answers import robot_answers
from circumspect.reproduction.robot_scans import RobotScans
from circumspect.reproduction.stages import measured, trained, write_report
from circumspect.reproduction.start_answers import StartAnswers
from circumspect.reproduction.table2 import NETS, OURS, Table2
from circumspect.reproduction.training_record import training_record, training_table
from circumspect.reproduction.watched import Watched
from circumspect.training import TrainingSettings

PAPERS_STARTS = "4 starts"
SHOWN = 3_400
"""Objects that an epoch on ModelNet10 shows. One on scans shows about as many, so that the schedule
is the same in both halves of the table."""
SEEDS = 3
"""Trainings of the network of the paper's choice, and of ours."""
SEEDED = (("cylindrical", "rwmp"), None)
"""Rows that are trained with several seeds; None is ours."""
SHIPPED = "robot"
"""Name of the robot's classifier."""
OTHER = "another class"
"""The robot's classifier knows more classes than the set."""


def reproduce_robot(
    scans: RobotScans, how: Table2, folder: Path, watched: Watched, cache: GridCache | None = None
) -> dict[str, Any]:
    """Train on scans from the first start, test on other objects' scans from every start.

    The four networks of the paper and ours; and the shipped classifier of the robot, which is not
    trained on the set. Nothing is turned: each cloud lies as its robot has it, whose map begins
    where it started.

    Args:
        scans: That train and test.
        how: Settings.
        folder: For the runs, `table2_robot.md`, `table2_robot.json` and the figures.
        watched: Notified of the progress.
        cache: Where grids are kept.

    Returns:
        What `table2_robot.json` holds.

    Raises:
        InputError: The folder holds results of another experiment.
        OutputError: It can not be written.
    """
    networks: list[tuple[str, str, str, GridRecipe | None, tuple[str, str] | None]] = [
        (f"{kind}, {pool}", f"robot-{kind}-{pool}", NETS[pool], GridRecipe(kind, how.shape),
         (kind, pool))
        for kind, pool in ROBOT
    ]  # fmt: skip
    networks.append((f"ours ({OURS})", f"robot-{OURS}", OURS, None, None))
    rows = []
    for title, name, net, recipe, published in networks:
        found = [
            _tested(name, net, seed, scans, how, folder, watched, cache, recipe)
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
    recipe: GridRecipe | None,
) -> tuple[StartAnswers, dict[str, float]]:
    """A network's answers to the scans from every start, and how it was trained."""
    settings = as_long(how.settings(net), len(scans.train))
    settings = replace(settings, seed=how.seed + seed)
    name = f"{name}-{seed}" if seed else name
    with watched.training(name, settings.epochs) as observer:
        weights = trained(
            scans.train, settings, recipe or net_spec(net).recipe, folder / name / "training",
            observer, cache,
        )  # fmt: skip
    sweeps = {}
    for start, objects in scans.tests.items():
        with watched.measuring(f"{name} from {start:g}°") as progress:
            at = folder / name / f"start_{start:g}"
            sweeps[start] = measured(weights, objects, [0.0], at, progress)
    return StartAnswers.of_sweeps(sweeps, scans.tests), training_record(weights)


def as_long(meant: TrainingSettings, count: int) -> TrainingSettings:
    """How a network that is meant for ModelNet10 is trained on a smaller set: as many steps.

    Args:
        meant: Its settings.
        count: Training scans.
    """
    return replace(meant, passes=max(1, round(SHOWN / count)))


def _draw(answers: StartAnswers, path: Path) -> None:
    """The confusion matrix of all answers to the scans from the paper's starts."""
    counts, classes = answers.confusion(ANGLES_DEG), [*answers.classes, OTHER]
    if not counts[:, -1].any():
        counts, classes = counts[:-1, :-1], classes[:-1]
    save_figure(draw_confusion(counts, classes, PAPERS_STARTS), path)


def _row(
    name: str,
    found: Sequence[tuple[StartAnswers, dict[str, float] | None]],
    published: tuple[float, ...] | None,
) -> dict[str, Any]:
    """Means over the seeds, and what each seed gave."""
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
    """The figure's file."""
    return f"confusion_robot_{'_'.join(re.findall('[a-z]+', network))}.png"
