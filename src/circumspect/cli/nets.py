"""`circumspect nets`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from circumspect.errors import MissingExtraError


@dataclass(frozen=True)
class Nets:
    """Every network, with its size and work."""

    json: bool = False
    """One JSON object a line on standard output and nothing else there."""
    classes: int = 10
    """How many classes to count for."""

    def run(self) -> int:
        """List them."""
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
    from circumspect.nets import NETS, cost_of

    records = []
    for spec in NETS.values():
        cost = cost_of(spec.build(classes, spec.recipe.shape), spec.recipe.shape)
        records.append(
            {
                "name": spec.name,
                "parameters": cost.parameters,
                "multiply_adds": cost.multiply_adds,
                "input": {"kind": spec.recipe.kind, "shape": list(spec.recipe.shape)},
                "summary": spec.summary,
            }
        )
    return records


def _show(records: list[dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for heading in ("name", "parameters", "multiply-adds", "input", "what it is"):
        numeric = heading in ("parameters", "multiply-adds")
        table.add_column(heading, justify="right" if numeric else "left", no_wrap=numeric)
    for record in records:
        shape = "x".join(str(cells) for cells in record["input"]["shape"])
        table.add_row(
            record["name"],
            f"{record['parameters']:,}",
            f"{record['multiply_adds'] / 1e6:,.0f} M",
            f"{record['input']['kind']} {shape}",
            record["summary"],
        )
    Console().print(table)
