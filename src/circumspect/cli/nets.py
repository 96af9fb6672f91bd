"""`circumspect nets`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from circumspect.errors import InputError, MissingExtraError

MOST_CLASSES = 100_000
"""The largest networks then have gigabytes of weights."""


@dataclass(frozen=True)
class Nets:
    """Every network, with its size and work.

    $ circumspect nets
    $ circumspect nets --classes 40 --json
    """

    json: bool = False
    """One JSON object a line on standard output and nothing else there."""
    classes: int = 10
    """How many classes to count for."""

    def run(self) -> int:
        """List them."""
        if not 1 <= self.classes <= MOST_CLASSES:
            raise InputError(f"--classes {self.classes}: give 1 to {MOST_CLASSES}")
        try:
            import torch  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("torch", "train") from error
        records = _records(self.classes)
        if self.json:
            for record in records:
                print(json.dumps(record))  # noqa: T201
        else:
            _show(records)
        return 0


def _records(classes: int) -> list[dict[str, Any]]:
    from circumspect.nets import NETS, build_net, cost_of

    records = []
    for spec in NETS.values():
        cost = cost_of(build_net(spec.name, classes, spec.recipe), spec.recipe.input_shape)
        records.append(
            {
                "name": spec.name,
                "parameters": cost.parameters,
                "multiply_adds": cost.multiply_adds,
                "input": {"kind": spec.recipe.kind, "shape": list(spec.recipe.input_shape[-3:])},
                "summary": spec.summary,
                "source": spec.source,
                "departures": spec.departures,
            }
        )
    return records


def _show(records: list[dict[str, Any]]) -> None:
    from rich.table import Table

    from circumspect.cli.console import OutputConsole

    table = Table(box=None, pad_edge=False)
    for heading in ("name", "weights", "mult-adds", "input", "what it is"):
        numeric = heading in ("weights", "mult-adds")
        table.add_column(
            heading, justify="right" if numeric else "left", no_wrap=heading != "what it is"
        )
    for record in records:
        kind, shape = record["input"]["kind"], record["input"]["shape"]
        cells = str(shape[0]) if kind == "points" else "x".join(map(str, shape))
        table.add_row(
            record["name"],
            f"{record['parameters'] / 1e6:.2f} M",
            f"{record['multiply_adds'] / 1e6:,.0f} M",
            f"{kind}\n{cells}",
            f"{record['summary']} ({record['source']})",
        )
    console = OutputConsole()
    console.print(table)
    console.print("\nWhere they depart from their sources:")
    for record in records:
        if record["departures"]:
            console.print(f"{record['name']}: {record['departures']}.", highlight=False)
