"""Tables of measurements, with the machine and the versions that made them."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

from circumspect.storage import atomic_open, write_json

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("circumspect", "numpy", "scipy", "trimesh", "onnxruntime")


@dataclass(frozen=True)
class Row:
    """One measurement.

    Attributes:
        name: What was timed.
        median: [ms].
        p95: 95th percentile [ms].
        repeats: How often.
    """

    name: str
    median: float
    p95: float
    repeats: int


def machine() -> dict[str, str | int]:
    """What the numbers depend on."""
    versions = {package: metadata.version(package) for package in PACKAGES}
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "python": platform.python_version(),
        **versions,
    }


def write_report(name: str, command: str, rows: Sequence[Row]) -> None:
    """Print the table and write it to `benchmarks/results/NAME.{md,json}`."""
    facts = machine()
    text = table(rows)
    print(text)
    with atomic_open(RESULTS / f"{name}.md") as stream:
        title = name.replace("_", " ").capitalize()
        stream.write(f"# {title}\n\n`{command}`\n\n```\n{text}\n```\n\n")
        stream.write("".join(f"- {key}: {value}\n" for key, value in facts.items()))
    document = {"command": command, "machine": facts, "rows": [asdict(row) for row in rows]}
    write_json(RESULTS / f"{name}.json", document)


def table(rows: Sequence[Row]) -> str:
    """Fits 80 columns."""
    lines = [f"{'what':46} {'median ms':>10} {'p95 ms':>10} {'repeats':>8}"]
    lines += [f"{r.name:46} {r.median:10.3f} {r.p95:10.3f} {r.repeats:8}" for r in rows]
    return "\n".join(lines)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
