"""`circumspect data import sweethome3d`."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

from circumspect.errors import printable

SHOWN = 4
"""Number of skipped pieces printed for each reason; --json lists all."""


def import_catalogues(path: Path, out: Path, as_json: bool) -> int:
    """Read all models, write the pack and print a summary.

    Args:
        path: A .sh3f file, or a folder of such files.
        out: The mesh pack.
        as_json: Print one JSON object instead of tables.

    Raises:
        InputError: A catalogue can not be read, or none of the models can.
        OutputError: The pack can not be written.
    """
    from circumspect.cli.progress import progress_bar
    from circumspect.datasets.mesh_pack import write_mesh_pack
    from circumspect.datasets.sweethome3d_classes import CLASSES
    from circumspect.datasets.sweethome3d_import import import_sweethome3d
    from circumspect.storage import require_writable

    require_writable(out.parent)
    with progress_bar("models") as progress:
        imported = import_sweethome3d(path, progress)
    write_mesh_pack(out, imported.entries, CLASSES)
    document = {"pack": str(out), "bytes": out.stat().st_size, **imported.to_dict()}
    print(json.dumps(document) if as_json else _readable(document))  # noqa: T201
    return 0


def _readable(document: dict[str, Any]) -> str:
    rows = [
        *document["classes"].items(),
        ("other", document["others"]),
        ("ambiguous", document["ambiguous"]),
        ("skipped", len(document["skipped"])),
    ]
    lines = [f"{'class':14}{'models':>8}", *(f"{name:14}{count:>8}" for name, count in rows)]
    lines += [
        "",
        f"{document['others_of_furniture_size']} of the others have the size of furniture.",
        *_skipped(document["skipped"]),
        "",
        "licences, to be named wherever the models are used:",
    ]
    for entry in document["catalogues"]:
        licence = entry["licence"] or "none stated"
        lines.append(f"  {entry['catalogue']}: {licence} ({entry['models']} models)")
    size = f"{document['bytes'] / 1e6:.1f} MB"
    lines += ["", f"{printable(document['pack'])}: {document['models']} models, {size}"]
    return "\n".join(lines)


def _skipped(pieces: list[dict[str, Any]]) -> list[str]:
    """One line for each reason, the most frequent first."""
    counts = Counter(piece["reason"] for piece in pieces)
    lines = []
    for reason, count in counts.most_common():
        names = [
            f"{piece['catalogue']} {piece['number']} {piece['name']}".rstrip()
            for piece in pieces
            if piece["reason"] == reason
        ]
        rest = f" and {count - SHOWN} more" if count > SHOWN else ""
        lines.append(f"skipped, {printable(reason)}: {', '.join(names[:SHOWN])}{rest}")
    return lines
