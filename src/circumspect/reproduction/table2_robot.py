"""Table 2 of the paper, its half on the robot's own set."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from circumspect import __version__
from circumspect.classification import GridRecipe
from circumspect.datasets import GridCache
from circumspect.evaluation.figures import draw_confusion, save_figure
from circumspect.evaluation.markdown import table
from circumspect.evaluation.yaw_sweep import YawSweep
from circumspect.nets.registry import net_spec
from circumspect.reproduction.published import ANGLES_DEG, ROBOT
from circumspect.reproduction.robot_scans import RobotScans
from circumspect.reproduction.stages import measured, trained, write_report
from circumspect.reproduction.table2 import NETS, OURS, Table2
from circumspect.reproduction.training_record import training_record, training_table
from circumspect.reproduction.watched import Watched
from circumspect.training import TrainingSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPERS_STARTS = "4 starts"
BATCH, MORE_EPOCHS = 8, 8
"""A set of some dozens of scans is shown in smaller batches, and so many times as often as the
thousands of ModelNet10; a network that saw each as rarely would have learnt nothing."""


def reproduce_robot(
    scans: RobotScans, how: Table2, folder: Path, watched: Watched, cache: GridCache | None = None
) -> dict[str, Any]:
    """Train on scans from the first start, test on other objects' scans from every start.

    The four networks of the paper and ours. Nothing is turned: each cloud lies as its robot has
    it, whose map begins where it started.

    Args:
        scans: That train and test.
        how: Settings.
        folder: For the runs, `table2_robot.md`, `table2_robot.json` and the figures.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        What `table2_robot.json` holds.

    Raises:
        InputError: The folder holds results of another experiment.
        OutputError: It can not be written.
    """
    rows = []
    for kind, pool in ROBOT:
        recipe = GridRecipe(kind, how.shape)
        name = f"robot-{kind}-{pool}"
        sweeps, record = _tested(name, NETS[pool], scans, how, folder, watched, cache, recipe)
        save_figure(_confusion(sweeps), folder / _confusions(f"{kind}, {pool}"))
        rows.append(_row(f"{kind}, {pool}", sweeps, record, ROBOT[kind, pool]))
    sweeps, record = _tested(f"robot-{OURS}", OURS, scans, how, folder, watched, cache)
    ours = f"ours ({OURS})"
    save_figure(_confusion(sweeps), folder / _confusions(ours))
    rows.append(_row(ours, sweeps, record, None))
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
    scans: RobotScans,
    how: Table2,
    folder: Path,
    watched: Watched,
    cache: GridCache | None,
    recipe: GridRecipe | None = None,
) -> tuple[dict[float, YawSweep], dict[str, float]]:
    """A network's answers to the scans from every start, and how it was trained."""
    settings = for_few(how.settings(net))
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
    return sweeps, training_record(weights)


def for_few(meant: TrainingSettings) -> TrainingSettings:
    """How a network that is meant for thousands of objects is trained on some dozens.

    The learning rate goes with the batch (Goyal et al. 2017).
    """
    return replace(
        meant,
        batch_size=BATCH,
        epochs=MORE_EPOCHS * meant.epochs,
        learning_rate=meant.learning_rate * BATCH / meant.batch_size,
    )


def _confusion(sweeps: dict[float, YawSweep]) -> Figure:
    """Of all answers to the scans from the paper's starts, as if they were one test."""
    some = [sweeps[start] for start in ANGLES_DEG]
    total = np.sum([sweep.confusion for sweep in some], axis=0)
    return draw_confusion(total, some[0].classes, PAPERS_STARTS)


def _row(
    name: str,
    sweeps: dict[float, YawSweep],
    record: dict[str, float],
    published: tuple[float, ...] | None,
) -> dict[str, Any]:
    accuracy = {f"{start:g}": float(sweep.accuracy[0]) for start, sweep in sweeps.items()}
    return {
        "network": name,
        "accuracy": accuracy,
        "paper": None if published is None else list(published),
        "worst": min(accuracy.values()),
        "training": record,
    }


def _markdown(document: dict[str, Any]) -> str:
    starts = list(document["test_scans"])
    paper = [f"{angle:g}" for angle in ANGLES_DEG]
    others = [start for start in starts if start not in paper]
    rows = []
    for row in document["rows"]:
        published = row["paper"] or [None] * len(paper)
        cells = [
            f"{row['accuracy'][start]:.3f}" + ("" if value is None else f" ({value:.2f})")
            for start, value in zip(paper, published, strict=True)
        ]
        cells += [f"{row['accuracy'][start]:.3f}" for start in others]
        rows.append([row["network"], *cells, f"{row['worst']:.3f}"])
    head = ["network", *(f"{start}°" for start in [*paper, *others]), "worst"]
    return (
        f"# Table 2: the robot's own set\n\n`{document['command']}`\n\n"
        f"Accuracy on scans of test objects by the azimuth of their start, in brackets that of the "
        f"paper on its own set. {document['train_scans']} scans from the first start train, of "
        f"{len(document['classes'])} classes ({', '.join(document['classes'])}); "
        f"{document['test_scans'][paper[0]]} scans a start test. Batches of {BATCH}, "
        f"{document['precision']}, seed {document['seed']}. Each robot starts up to 10° askew, so "
        "that no start is a whole number of cells from another.\n\n"
        + table(head, rows)
        + "\n\n"
        + training_table([row[0] for row in rows], [row["training"] for row in document["rows"]])
        + "".join(f"\n![Confusions, {row[0]}]({_confusions(row[0])})\n" for row in rows)
    )


def _confusions(network: str) -> str:
    """The figure's file."""
    return f"confusion_robot_{'_'.join(re.findall('[a-z]+', network))}.png"
