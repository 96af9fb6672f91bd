"""The results folder of an evaluation on labelled real objects."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from circumspect.datasets.labelled_crops import LabelledCrops
from circumspect.errors import printable
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect.evaluation.crop_figures import (
    draw_crop_confusion,
    draw_crop_reliability,
    draw_errors,
)
from circumspect.evaluation.crop_report import report_of
from circumspect.evaluation.figures import save_figure
from circumspect.storage import atomic_open, write_json

METRICS, REPORT = "metrics.json", "report.md"
OBJECTS_JSON, OBJECTS_CSV = "objects.jsonl", "objects.csv"
ERROR_PAGE = re.compile(r"errors(?:-[0-9]+)?\.png")
COLUMNS: tuple[str, ...] = (
    "source", "scene", "name", "label", "use", "answer", "probability", "correct", "confident",
    "in_distribution", "in_distribution_probability", "distance", "alternatives",
)  # fmt: skip
"""Columns of the CSV file; the JSON lines hold more."""


def write_crop_results(
    folder: Path, metrics: Mapping[str, Any], answers: Sequence[CropAnswer]
) -> str:
    """Write the measures, every object's answer and the report; pictures are added by
    `draw_crop_results`.

    Args:
        folder: Made where missing.
        metrics: From `crop_metrics`, with `command`.
        answers: From `answer_crops`.

    Returns:
        The report.

    Raises:
        OutputError: A file cannot be written.
    """
    write_json(folder / METRICS, metrics)
    with atomic_open(folder / OBJECTS_JSON) as stream:
        for answer in answers:
            stream.write(json.dumps(_record(answer), ensure_ascii=False) + "\n")
    with atomic_open(folder / OBJECTS_CSV) as stream:
        rows = csv.DictWriter(stream, COLUMNS, extrasaction="ignore", lineterminator="\n")
        rows.writeheader()
        rows.writerows(map(_row, answers))
    return _write_report(folder, metrics, ())


def draw_crop_results(
    folder: Path,
    metrics: Mapping[str, Any],
    answers: Sequence[CropAnswer],
    sources: Mapping[str, LabelledCrops],
) -> list[Path]:
    """Draw the pictures, and write the report again with links to them.

    Pages of errors that an earlier evaluation left in the folder are removed.

    Args:
        folder: Of `write_crop_results`.
        metrics: As there.
        answers: As there.
        sources: The classified objects.

    Returns:
        The files written.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: A file cannot be written.
    """
    figures = {"confusion.png": draw_crop_confusion(metrics)}
    if metrics["objects"]["known_classes"]:
        figures["reliability.png"] = draw_crop_reliability(metrics)
    for number, page in enumerate(draw_errors(answers, sources), start=1):
        figures["errors.png" if number == 1 else f"errors-{number}.png"] = page
    for name, figure in figures.items():
        save_figure(figure, folder / name)
    for old in folder.iterdir():
        if ERROR_PAGE.fullmatch(old.name) and old.name not in figures:
            with suppress(OSError):
                old.unlink()
    _write_report(folder, metrics, list(figures))
    return [folder / name for name in figures]


def _write_report(folder: Path, metrics: Mapping[str, Any], pictures: Sequence[str]) -> str:
    text = report_of(metrics, pictures)
    with atomic_open(folder / REPORT) as stream:
        stream.write(text)
    return text


def _record(answer: CropAnswer) -> dict[str, Any]:
    return {**answer.to_dict(), "probability": answer.probability, "correct": answer.correct}


def _row(answer: CropAnswer) -> dict[str, Any]:
    """Cells of a spreadsheet: texts cannot break a line, alternatives are one text."""
    cells = {
        key: printable(value) if isinstance(value, str) else value
        for key, value in _record(answer).items()
    }
    alternatives = "; ".join(f"{name} {p:.3f}" for name, p in answer.alternatives.items())
    return {**cells, "alternatives": alternatives}
