"""`circumspect models`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.model_flag import MODELNET10, NAMES, ROBOT
from circumspect.cli.say import say
from circumspect.errors import CircumspectError, printable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.table import Table

    from circumspect.classification.model_facts import ModelFacts

NONE = "–"
"""Printed in place of a figure that was not measured."""


@dataclass(frozen=True)
class Models:
    """List classifiers: shipped, taught, or your own file.

    $ circumspect models
    $ circumspect models robot
    $ circumspect models own.onnx --json
    """

    model: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(metavar="[NAME|FILE]")] = None
    """Print the details of this classifier: name of a shipped or taught one, or your own file. By
    default, print a table of all classifiers with names."""
    json: bool = False
    """Print one JSON object per line and classifier on standard output and nothing else."""

    def run(self) -> int:
        """Load and print them; a broken classifier does not hide the others."""
        from circumspect.classification.model_facts import ModelFacts

        if self.model is not None:
            found, failed = [ModelFacts.load(self.model)], False
        else:
            found, failed = _named()
        for facts in found:
            if facts.stale:
                say(f"{facts.name}: the figures beside it are of another file and not shown")
        if self.json:
            for facts in found:
                print(json.dumps(facts.to_dict()))  # noqa: T201
        else:
            _show(found, single=self.model is not None)
        return 1 if failed else 0


def _named() -> tuple[list[ModelFacts], bool]:
    """The shipped and taught classifiers that can be loaded, and whether any can not."""
    from circumspect.classification.model_facts import ModelFacts
    from circumspect.classification.shipped import own_model_names

    names = (*NAMES, *own_model_names())
    found: list[ModelFacts] = []
    for name in names:
        try:
            found.append(ModelFacts.load(name))
        except CircumspectError as error:
            say(str(error))
    return found, len(found) < len(names)


def _show(found: list[ModelFacts], single: bool) -> None:
    from circumspect.cli.console import OutputConsole

    console = OutputConsole(highlight=False)
    if single:
        console.print(_details(found[0]))
        return
    console.print(_overview(found))
    console.print(
        f"\nDefault: {ROBOT}; of evaluate and reproduce: {MODELNET10}.\n"
        "All about one: circumspect models NAME, or FILE.onnx of your own.",
        markup=False,
    )


def _overview(found: list[ModelFacts]) -> Table:
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    table.add_column("name", no_wrap=True)
    for heading in ("classes", "size", "network"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("trained on", "figures"):
        table.add_column(heading, overflow="fold")
    for facts in found:
        time = facts.card.network_time if facts.card else None
        headlines = facts.card.headlines if facts.card else ()
        table.add_row(
            facts.name,
            str(len(facts.classifier.classes)),
            _megabytes(facts),
            time.text if time else NONE,
            facts.training_data or NONE,
            "\n".join(f"{one.text} {one.measure}, {one.data}" for one in headlines) or NONE,
        )
    return table


def _details(facts: ModelFacts) -> Table:
    from rich.table import Table
    from rich.text import Text

    from circumspect.classification.model_facts import setting_text

    classifier, shipped = facts.classifier, facts.shipped
    rows = [("name", facts.name)]
    if shipped is not None:
        rows += [("purpose", shipped.summary)]
    if facts.training_data is not None:
        rows += [("trained on", facts.training_data)]
    rows += [
        (f"{len(classifier.classes)} classes", ", ".join(classifier.classes)),
        ("input", _settings(classifier.input_spec.to_dict())),
        ("network", str(classifier.description.get("name") or NONE)),
        ("training", _training(facts)),
        ("temperature", f"{classifier.temperature:g}"),
        *((key.replace("_", " "), setting_text(value)) for key, value in facts.open_set.items()),
        ("size", f"{_megabytes(facts)}, sha256 {facts.sha256[:16]}…"),
    ]
    figures = facts.card.figures if facts.card else ()
    for command, group in groupby(figures, lambda figure: figure.command):
        rows += [(one.text, f"{one.measure}, {one.data}") for one in group]
        rows.append(("", f"$ {command}"))
    if not figures:
        rows.append(("figures", NONE))
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for key, value in rows:
        # Plain text, because strings of a file are not markup.
        lines = "\n".join(map(printable, value.splitlines()))
        table.add_row(Text(printable(key)), Text(lines))
    return table


def _training(facts: ModelFacts) -> str:
    """Summary of the training; --json has all settings."""
    parts = []
    if facts.training_objects is not None:
        parts.append(f"{facts.training_objects:,} objects")
    if (epochs := facts.training_settings.get("epochs")) is not None:
        parts.append(f"{epochs} epochs")
    return ", ".join(parts) or NONE


def _settings(settings: Mapping[str, Any]) -> str:
    from circumspect.classification.model_facts import setting_text

    return ", ".join(f"{key} {setting_text(value)}" for key, value in settings.items())


def _megabytes(facts: ModelFacts) -> str:
    return f"{facts.size / 1e6:.1f} MB"
