"""What corrupted clouds do to the networks that are compared."""

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
from circumspect.reproduction.contenders import (
    OURS,
    Comparison,
    label_of,
    trained_contenders,
)
from circumspect.reproduction.stages import done_once, file_digest, is_stored, write_report
from circumspect.reproduction.watched import Watched


def reproduce_robustness(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> dict[str, Any]:
    """Name test objects at 0° after each corruption in each severity, with every network.

    Every stage whose result is in the folder is left as it is, a corruption of a network being
    one; the trainings are those of `reproduce_rivals`. Where `how` asks for some rows only, the
    table holds these and every other one that is finished.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split.
        how: Settings; the yaws do not count.
        folder: For the runs, `robustness.md` and `robustness.json`.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        What `robustness.json` holds.

    Raises:
        WeightsError: The shipped classifier knows other classes than the set.
        InputError: The folder holds results of another experiment.
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
    """Whether all corruptions of a row are there."""
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
        "networks meet the same clouds. The docs' page on networks tells what each corruption does."
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
