"""`circumspect nets`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.nets import NetSpec
    from circumspect.plugins import Plugin

MOST_CLASSES = 100_000
"""At this limit the largest networks have gigabytes of weights."""


@dataclass(frozen=True)
class Nets:
    """List all networks, also those of plug-ins, with parameters and multiply-adds.

    $ circumspect nets
    $ circumspect nets --classes 40 --json
    $ circumspect nets --net my_package.my_net:NET

    The exit code is 1 if a plug-in can not be used.
    """

    net: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME|MODULE:NAME")] = ()
    """List only these networks; MODULE:NAME is your own NetSpec."""
    json: bool = False
    """Print one JSON object per line on standard output and nothing else."""
    classes: int = 10
    """Number of classes for which parameters and multiply-adds are counted."""

    def run(self) -> int:
        """Print the networks."""
        if not 1 <= self.classes <= MOST_CLASSES:
            raise InputError(f"--classes {self.classes}: give 1 to {MOST_CLASSES}")
        try:
            import torch  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("torch", "train") from error
        records, failed = self._records()
        if self.json:
            for record in records:
                print(json.dumps(record))  # noqa: T201
        elif records:
            _show(records)
        return 1 if failed else 0

    def _records(self) -> tuple[list[dict[str, Any]], bool]:
        """One record per network, and whether any plug-in can not be used; each is reported."""
        from circumspect.nets import NETS
        from circumspect.nets.registry import NETWORKS, net_spec

        if self.net:
            return [_record(net_spec(name), self.classes, None) for name in self.net], False
        records = [_record(spec, self.classes, None) for spec in NETS.values()]
        failed = False
        for plugin in NETWORKS.plugins():
            try:
                if plugin.error is not None:
                    raise InputError(plugin.error)
                records.append(_record(net_spec(plugin.name), self.classes, plugin))
            except InputError as error:
                failed = True
                say(str(error))
        return records, failed


def _record(spec: NetSpec, classes: int, plugin: Plugin | None) -> dict[str, Any]:
    from circumspect.nets import build_net, cost_of

    cost = cost_of(build_net(spec.name, classes, spec.input_spec), spec.input_spec.input_shape)
    return {
        "name": spec.name,
        "parameters": cost.parameters,
        "multiply_adds": cost.multiply_adds,
        "input": {"kind": spec.input_spec.kind, "shape": list(spec.input_spec.input_shape[-3:])},
        "summary": spec.summary,
        "source": spec.source,
        "departures": spec.departures,
        "distribution": None if plugin is None else plugin.distribution,
    }


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
            printable(f"{record['summary']} ({record['distribution'] or record['source']})"),
        )
    console = OutputConsole()
    console.print(table)
    console.print("\nWhere they depart from their sources:")
    for record in records:
        if record["departures"]:
            console.print(f"{record['name']}: {record['departures']}.", highlight=False)
