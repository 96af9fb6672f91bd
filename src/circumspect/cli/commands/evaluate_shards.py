"""`circumspect evaluate` on a set in shards."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect import __version__
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, OutputError, WeightsError, printable

if TYPE_CHECKING:
    from rich.table import Table

    from circumspect.datasets.shard_file import ShardHead
    from circumspect.evaluation.predictor import TrainedPredictor
    from circumspect.evaluation.shard_answers import ShardAnswers
    from circumspect.gathering import JobPool

DONE = "shards.jsonl"
"""One line for each evaluated shard; the same command resumes from it."""


def evaluate_shards(
    model: str,
    identity: Mapping[str, str],
    url: str,
    split: str,
    out: Path,
    pool: JobPool,
    as_json: bool,
) -> int:
    """Evaluate, write the results and print the report.

    Args:
        model: Argument of `load_predictor`.
        identity: "model", its name in the report, and "sha256" of its file.
        url: URL of the set.
        split: The evaluated split.
        out: Folder of the results.
        pool: Evaluates the shards.
        as_json: Print the measures as JSON instead of the report.

    Returns:
        Exit code.

    Raises:
        InputError: A shard is missing, broken, or does not fit the network.
        WeightsError: The network has other classes than the set.
        OutputError: The results can not be written, or a shard could not be evaluated.
    """
    from circumspect.datasets.sharded_set import ShardedSet
    from circumspect.evaluation.predictor import load_predictor
    from circumspect.storage import write_json

    predictor = load_predictor(model)
    with ShardedSet.read(url, split) as shards:
        head, names = shards.head, shards.names
    _require_fit(predictor, head, url)
    described = {
        "circumspect": __version__, **identity, "split": split, "data": head.digest,
    }  # fmt: skip
    _claim(out, described)
    records = _evaluated(model, url, names, out, pool)
    from circumspect.evaluation.shard_answers import ShardAnswers

    answers = ShardAnswers.added(records)
    seen = answers.fitted > 0 or predictor.training.get("data") == head.digest
    metrics = {
        **described, "seen_in_training": seen, "shards": len(names),
        "classes": list(head.classes), **answers.metrics(),
    }  # fmt: skip
    write_json(out / "metrics.json", metrics)
    if as_json:
        print(json.dumps(metrics))  # noqa: T201
    else:
        from circumspect.cli.console import show

        show(*_readable(metrics, out))
    _draw(answers, head.classes, out)
    return 0


def _require_fit(predictor: TrainedPredictor, head: ShardHead, url: str) -> None:
    """Check that a set has the input specification and the classes of a network."""
    if predictor.classes != head.classes:
        raise WeightsError(
            f"the weights know {', '.join(predictor.classes)}, but the set has "
            f"{', '.join(head.classes)}; evaluate on a set of the same classes"
        )
    if predictor.input_spec.to_dict() != head.input_spec:
        raise InputError(
            f"{url}: its grids are of another input specification than the network's; convert the "
            "set for this network"
        )


def _claim(out: Path, described: Mapping[str, Any]) -> None:
    """Remove answers of another network or set."""
    from circumspect.storage import write_json

    path = out / "evaluation.json"
    try:
        same = json.loads(path.read_text(encoding="utf-8")) == described
    except (OSError, ValueError):
        same = False
    write_json(path, dict(described))
    if not same:
        (out / DONE).unlink(missing_ok=True)


def _evaluated(
    model: str, url: str, names: list[str], out: Path, pool: JobPool
) -> list[dict[str, Any]]:
    """The record of each shard."""
    from circumspect.cli.progress import progress_bar
    from circumspect.evaluation.shard_answers import ShardJob, answers_of_shard
    from circumspect.gathering.job_pool import records
    from circumspect.storage import append_line

    found = {record["key"]: record for record in records(out / DONE)}
    jobs = [ShardJob(url, name, model) for name in names if name not in found]
    failed: list[str] = []
    with progress_bar(f"shards, {pool.name}") as progress:
        progress(len(names) - len(jobs), len(names))
        for done, (job, outcome) in enumerate(
            pool.outcomes(jobs, answers_of_shard), len(names) - len(jobs) + 1
        ):
            if isinstance(outcome, InputError):
                raise outcome
            if isinstance(outcome, BaseException):
                failed.append(f"{job.key} ({outcome})")
            else:
                append_line(out / DONE, json.dumps(outcome))
                found[job.key] = outcome
            progress(done, len(names))
    if failed:
        raise OutputError(
            f"{url}: {len(failed)} shards failed, the first: {failed[0]}; the same command tries "
            "them again"
        )
    return [found[name] for name in names]


def _readable(metrics: Mapping[str, Any], out: Path) -> list[str | Table]:
    lines: list[str | Table] = [
        f"{metrics['objects']} grids of {metrics['split']} in {metrics['shards']} shards",
        f"accuracy {metrics['accuracy']:.4f}, mean-class {metrics['mean_class_accuracy']:.4f}, "
        f"expected calibration error {metrics['expected_calibration_error']:.4f}",
    ]
    if "starts_deg" in metrics:
        from circumspect.cli.console import new_table

        table = new_table([], ["start [°]", "accuracy"])
        for start, accuracy in zip(
            metrics["starts_deg"], metrics["accuracy_from_start"], strict=True
        ):
            table.add_row(f"{start:.2f}", f"{accuracy:.4f}")
        lines.append(table)
    if metrics["seen_in_training"]:
        lines.append("the network was trained on objects of this set: do not quote these figures")
    return [*lines, f"metrics and figures: {printable(str(out))}"]


def _draw(answers: ShardAnswers, classes: tuple[str, ...], out: Path) -> None:
    from circumspect.evaluation.figures import draw_confusion, draw_reliability, save_figure

    total = f"{answers.total.sum()} grids"
    try:
        save_figure(draw_confusion(answers.total, classes, total), out / "confusion.png")
        save_figure(draw_reliability(answers.reliability, total), out / "reliability.png")
    except MissingExtraError as error:
        say(f"no figures: {error}")
