"""Model cards of the documentation, from the weights and their measured figures.

python -m benchmarks.model_cards            # writes docs/models/robot.md and modelnet10.md
python -m benchmarks.model_cards --check    # fails if they are not up to date

The ONNX file provides classes, input and training, and the card beside it the figures. Use, limits,
sources and their licences are in `benchmarks/model_texts/NAME.json`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

from circumspect.classification.example_table import examples_path
from circumspect.classification.model_facts import ModelFacts, setting_text
from circumspect.classification.shipped import SHIPPED, model_path
from circumspect.evaluation.markdown import table
from circumspect.storage import atomic_open

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs" / "models"
TEXTS = Path(__file__).parent / "model_texts"
TO_ROOT = "../.."
"""Path from the pages to the repository."""
SETTINGS = ("setting", "value")
"""The columns of tables of settings."""


@dataclass(frozen=True)
class ModelText:
    """Handwritten text about a classifier, without measured figures.

    Attributes:
        intended_use: Paragraphs on its use.
        properties: Further rows of the first table, by name.
        training_data: Rows with name, used, licence and source.
        training: Lines on its training.
        commands: Commands that train and export it.
        figures: Paragraphs that explain the figures.
        limits: Lines on its limits.
        attributions: Works that the training data contains: rows with work, creator, licence and
            source.
    """

    intended_use: Sequence[str] = ()
    properties: dict[str, str] = field(default_factory=dict)
    training_data: Sequence[dict[str, str]] = ()
    training: Sequence[str] = ()
    commands: Sequence[str] = ()
    figures: Sequence[str] = ()
    limits: Sequence[str] = ()
    attributions: Sequence[dict[str, str]] = ()

    @staticmethod
    def load(file: Path) -> ModelText:
        """Read a text.

        Raises:
            ValueError: An entry has another name.
        """
        document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        known = {one.name for one in fields(ModelText)}
        if unknown := set(document) - known:
            raise ValueError(f"{file}: unknown {sorted(unknown)}; known: {sorted(known)}")
        return ModelText(**document)


def page(facts: ModelFacts, text: ModelText) -> str:
    """The card of a shipped classifier in Markdown."""
    shipped = facts.shipped
    assert shipped is not None
    sections = [
        f"# Model card: `{shipped.name}`\n\n"
        "Made by `python -m benchmarks.model_cards`; the figures come from "
        f"`{shipped.name}.card.json` beside the weights.\n\n"
        f'{_sentence(shipped.summary)} Load it with `Classifier.load("{shipped.name}")` or '
        f"`--model {shipped.name}`.",
        _section("Intended use", *text.intended_use),
        _section("The network", table(["", ""], _network(facts, text))),
        _section("Input", table(SETTINGS, _settings(facts.classifier.input_spec.to_dict()))),
        _section("Training data", *_data(facts, text)),
        _section("Training", *_training(facts, text)),
        _section("Figures", *_figures(facts), *text.figures),
        _section("Limits", _bullets(text.limits)),
        _section("Attributions", *_attributions(text)),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _network(facts: ModelFacts, text: ModelText) -> list[list[str]]:
    classifier, path = facts.classifier, model_path(facts.name)
    rows = [
        ["classes", ", ".join(classifier.classes)],
        ["network", f"`{classifier.description.get('name')}`"],
    ]
    rows += [[key, value] for key, value in text.properties.items()]
    rows.append(["temperature", f"{classifier.temperature:g}"])
    rows += _open_set(facts.open_set)
    rows.append(["file", f"`{path.name}`, {facts.size / 1e6:.1f} MB, sha256 `{facts.sha256}`"])
    if (beside := examples_path(path)).is_file():
        size = beside.stat().st_size / 1e6
        content = "names and features of the training objects, for [explain](../explain.md)"
        rows.append(["beside it", f"`{beside.name}`, {size:.1f} MB: {content}"])
    return rows


def _open_set(described: Mapping[str, Any]) -> list[list[str]]:
    """When an object is called unknown, and when an answer is confident."""
    rows = []
    for key, value in described.items():
        if key == "other":
            rows.append(["output for other kinds", f"`{value}`"])
        elif key == "confidence":
            runs = groupby(zip(value["coverage"], value["probability"], strict=True), itemgetter(1))
            bounds = ((next(run)[0], p) for p, run in runs)
            shown = [f"{100 * p:.1f} % from {100 * c:.0f} % coverage on" for c, p in bounds]
            shown.append(f"{100 * value['without_coverage']:.1f} % where it is unknown")
            rows.append(["least probability of a confident answer", "; ".join(shown)])
        else:
            rows.append([key.replace("_", " "), setting_text(value)])
    return rows


def _settings(settings: Any) -> list[list[str]]:
    """Rows of settings, those within others by their path."""
    rows = []
    for key, value in settings.items():
        if isinstance(value, dict):
            rows += [[f"`{key}.{inner[0][1:]}", inner[1]] for inner in _settings(value)]
        elif value not in (None, ""):
            rows.append([f"`{key}`", setting_text(value)])
    return rows


def _data(facts: ModelFacts, text: ModelText) -> list[str]:
    assert facts.shipped is not None
    count = "" if facts.training_objects is None else f": {facts.training_objects:,} objects"
    parts = [_sentence(f"{facts.shipped.training_data}{count}")]
    if text.training_data:
        head = ["name", "used", "licence", "source"]
        parts.append(table(head, _cells(text.training_data, head)))
    return parts


def _training(facts: ModelFacts, text: ModelText) -> list[str]:
    parts = ["```sh\n" + "\n".join(text.commands) + "\n```"] if text.commands else []
    if text.training:
        parts.append(_bullets(text.training))
    if facts.training_settings:
        parts.append("Settings, as the file records them:")
        parts.append(table(SETTINGS, _settings(facts.training_settings)))
    return parts


def _figures(facts: ModelFacts) -> list[str]:
    if facts.card is None:
        return ["–"]
    rows = [
        [one.measure, one.text, one.data, f"[`{one.command}`]({TO_ROOT}/{one.source})"]
        if one.source
        else [one.measure, one.text, one.data, f"`{one.command}`"]
        for one in facts.card.figures
    ]
    return [table(["measure", "value", "data", "measured by"], rows)]


def _attributions(text: ModelText) -> list[str]:
    if not text.attributions:
        return []
    head = ["work", "creator", "licence", "source"]
    rows = table(head, _cells(text.attributions, head))
    return ["The training data contains these works of others.", rows]


def _cells(rows: Sequence[dict[str, str]], head: Sequence[str]) -> list[list[str]]:
    """The cells of a table; names of works and creators may contain its separator."""
    return [[row[name].replace("|", r"\|") for name in head] for row in rows]


def _section(title: str, *parts: str) -> str:
    """A section; empty without content."""
    content = [part for part in parts if part]
    return "\n\n".join([f"## {title}", *content]) if content else ""


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."


def _bullets(lines: Sequence[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def pages() -> dict[Path, str]:
    """Every card by its file."""
    return {
        PAGES / f"{name}.md": page(ModelFacts.load(name), ModelText.load(TEXTS / f"{name}.json"))
        for name in SHIPPED
    }


def main() -> int:
    """Write the cards, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check, code = parser.parse_args().check, 0
    for file, text in pages().items():
        if not check:
            with atomic_open(file) as stream:
                stream.write(text)
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            place = file.relative_to(ROOT)
            print(f"{place}: run python -m benchmarks.model_cards", file=sys.stderr)
            code = 1
    return code


if __name__ == "__main__":
    sys.exit(main())
