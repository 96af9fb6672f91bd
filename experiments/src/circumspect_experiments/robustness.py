"""Accuracy of the compared networks on corrupted clouds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from circumspect import __version__
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.corruption import CORRUPTIONS, SEVERITIES
from circumspect.evaluation.markdown import table
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.robustness import PASSES, measure_robustness
from circumspect_experiments.contenders import (
    OURS,
    Comparison,
    label_of,
    trained_contenders,
)
from circumspect_experiments.stages import Watched, done_once, file_digest, is_stored, write_report


def reproduce_robustness(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Classify test objects at 0° with every network, for each corruption and severity.

    Finished stages in the folder are kept; a stage is one corruption of one network. The trainings
    are those of `reproduce_rivals`. If `how` requests some rows only, the table holds these and
    every other finished one.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split.
        how: Settings; the yaws are not used.
        folder: For the runs, `robustness.md` and `robustness.json`.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Content of `robustness.json`.

    Raises:
        WeightsError: The shipped classifier has other classes than the set.
        InputError: The folder contains results of another experiment.
        OutputError: It can not be written.
    """
    weights, records = trained_contenders(train, test, how, folder, watched, cache)
    rows = {}
    for net, path in weights.items():
        at = folder / net / "corrupted"
        if not how.asks_for(net) and not _is_measured(path, test, how.seed, at):
            continue
        with watched.measuring(f"{net}, corrupted", "corruptions") as progress:
            rows[net] = _measured(path, test, how.seed, at, progress)
    how = how.of_rows(rows)
    document = {
        "circumspect": __version__, "command": how.command("robustness --data modelnet10"),
        "objects": len(test), "precision": how.precisions, "seed": how.seed, "nets": rows,
        "training": {net: record for net, record in records.items() if net in rows},
    }  # fmt: skip
    write_report(document, _markdown(document), folder, "robustness")
    return document


def _measured(
    weights: Path, test: ObjectSet, seed: int, folder: Path, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    made_of = _made_of(weights, test, seed)

    def keep(kind: str, measure: Callable[[], list[float]]) -> list[float]:
        form = [float] * len(PASSES[kind])
        return done_once(folder / kind, {**made_of, "corruption": kind}, measure, form)

    return measure_robustness(load_predictor(weights), test, seed, progress, keep).to_dict()


def _is_measured(weights: Path, test: ObjectSet, seed: int, folder: Path) -> bool:
    """Whether all corruptions of a row exist."""
    made_of = _made_of(weights, test, seed)
    return all(is_stored(folder / kind, {**made_of, "corruption": kind}) for kind in PASSES)


def _made_of(weights: Path, test: ObjectSet, seed: int) -> dict[str, Any]:
    return {"weights": file_digest(weights), "data": test.digest, "seed": seed}


def _markdown(document: dict[str, Any]) -> str:
    nets = document["nets"]
    head = ["corruption", *map(label_of, nets)]
    over = {kind: [_mean(row["accuracy"][kind]) for row in nets.values()] for kind in CORRUPTIONS}
    rows = [
        ["none", *(f"{row['clean']:.3f}" for row in nets.values())],
        *([kind, *(f"{value:.3f}" for value in values)] for kind, values in over.items()),
        ["mean of all", *(f"{row['mean']:.3f}" for row in nets.values())],
    ]
    return (
        "# Networks on corrupted objects\n\n"
        f"`{document['command']}`\n\n"
        f"Accuracy on {document['objects']} test objects at 0°, mean of five severities; all "
        "networks get the same clouds. The page on networks describes each corruption."
        "\n\n"
        + table(head, rows)
        + "\n"
        + (_by_severity(nets[OURS]["accuracy"]) if OURS in nets else "")
    )


def _by_severity(accuracy: dict[str, list[float]]) -> str:
    rows = [[kind, *(f"{value:.3f}" for value in accuracy[kind])] for kind in CORRUPTIONS]
    return (
        f"\n`{OURS}`, the shipped classifier, by severity:\n\n"
        + table(["corruption", *(str(severity) for severity in SEVERITIES)], rows)
        + "\n"
    )


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)
