"""`circumspect data`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import tyro

SHOWN = 8
"""Of each list; --json tells all."""


@dataclass(frozen=True)
class Data:
    """Data sets: whether a copy of ModelNet10 is complete and can be read.

    $ circumspect data verify ModelNet10
    """

    what: tyro.conf.Positional[Literal["verify"]]
    """verify: count every class and split, and name what is missing, foreign or broken."""
    path: tyro.conf.Positional[Path]
    """Folder with point packs, or ModelNet10's folder of OFF files."""
    json: bool = False
    """One JSON object and nothing else on standard output."""

    def run(self) -> int:
        """Verify; 1 where something is missing or broken."""
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.verification import verify

        with progress_bar("files") as progress:
            found = verify(self.path, progress)
        document = found.to_dict()
        print(json.dumps(document) if self.json else _readable(document))  # noqa: T201
        return 0 if found.complete else 1


def _readable(document: dict[str, Any]) -> str:
    from circumspect.datasets.verification import MODELNET10

    lines = [f"{'class':14}{'train':>12}{'test':>12}"]
    for name, wanted in MODELNET10.items():
        cells = [
            f"{document['counts'][split][name]} of {count}"
            for split, count in zip(("train", "test"), wanted, strict=True)
        ]
        lines.append(f"{name:14}{cells[0]:>12}{cells[1]:>12}")
    broken = [entry["fault"] for entry in document["broken"]]
    for what, entries in (
        ("missing", document["missing"]), ("broken", broken), ("foreign", document["foreign"]),
    ):  # fmt: skip
        if entries:
            more = len(entries) - SHOWN
            rest = f", and {more} more (all with --json)" if more > 0 else ""
            lines.append(f"{what}: {', '.join(entries[:SHOWN])}{rest}")
    lines.append("complete" if document["complete"] else "not complete")
    return "\n".join(lines)
