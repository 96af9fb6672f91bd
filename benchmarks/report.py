"""Tables of measurements, with the machine and the versions that made them."""

from __future__ import annotations

import os
import platform
import re
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.storage import atomic_open, write_json

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("circumspect", "numpy", "scipy", "trimesh", "small_gicp", "onnxruntime")


@dataclass(frozen=True)
class Row:
    """One measurement; times in [ms].

    Attributes:
        name: What was timed.
        median: Median of the repetitions.
        p95: Their 95th percentile.
        minimum: Their minimum, the most reliable figure on a busy machine.
        repeats: Number of repetitions.
    """

    name: str
    median: float
    p95: float
    minimum: float
    repeats: int


def progress_report() -> Callable[[int, int, str], None]:
    """A callback that prints the number of finished jobs and the estimated time left."""
    start, before = time.monotonic(), []

    def report(done: int, total: int, key: str) -> None:
        if not before:
            before.append(done)
            print(f"{done} of {total} are done already", file=sys.stderr)
            return
        spent = (time.monotonic() - start) / 60
        left = spent / (done - before[0]) * (total - done)
        print(f"{done}/{total} {key} {spent:.1f} min, {left:.0f} min left", file=sys.stderr)

    return report


def timed(name: str, work: Callable[[], object], seconds: float = 1.0) -> Row:
    """Repeat `work` for a time [s], 8 to 200 times, after a warm-up."""
    return timed_in_turn({name: work}, seconds)[0]


def timed_in_turn(works: Mapping[str, Callable[[], object]], seconds: float = 1.0) -> list[Row]:
    """Like `timed`, for a comparison: each repetition runs all functions, one after the other.

    Other load on the machine then slows all of them equally.
    """
    for work in works.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in works}
    until, rounds = time.perf_counter() + seconds * len(works), 0
    while rounds < 8 or (rounds < 200 and time.perf_counter() < until):
        for name, work in works.items():
            start = time.perf_counter()
            work()
            times[name].append(1e3 * (time.perf_counter() - start))
        rounds += 1
    return [_row(name, of_work) for name, of_work in times.items()]


def _row(name: str, times: Sequence[float]) -> Row:
    median, p95 = np.percentile(times, [50, 95])
    return Row(name, float(median), float(p95), min(times), len(times))


def machine() -> dict[str, str | int]:
    """The machine and the versions that the numbers depend on."""
    versions = {package: metadata.version(package) for package in PACKAGES}
    return {
        "processor": processor(),
        "cores": os.cpu_count() or 1,
        "python": platform.python_version(),
        **versions,
    }


def write_report(
    name: str, command: str, rows: Sequence[Row], notes: str = "", folder: Path = RESULTS
) -> None:
    """Print the table and write it to `NAME.md` and `NAME.json` in a folder."""
    facts = machine()
    text = f"{table(rows)}\n\n{notes}".strip()
    print(text)
    with atomic_open(folder / f"{name}.md") as stream:
        title = name.replace("_", " ").capitalize()
        stream.write(f"# {title}\n\n`{command}`\n\n```\n{text}\n```\n\n")
        stream.write("".join(f"- {key}: {value}\n" for key, value in facts.items()))
    document = {"command": command, "machine": facts, "rows": [asdict(row) for row in rows]}
    write_json(folder / f"{name}.json", document)


def write_page(
    name: str,
    title: str,
    command: str,
    text: str,
    measured: Mapping[str, Any],
    folder: Path = RESULTS,
    more_facts: Mapping[str, str | int] | None = None,
) -> None:
    """Print a text and write it, with the machine, to `NAME.md`; the figures to `NAME.json`."""
    facts = {**machine(), **(more_facts or {})}
    page = f"{text}\n\n" + "".join(f"- {key}: {value}\n" for key, value in facts.items())
    print(page)
    with atomic_open(folder / f"{name}.md") as stream:
        stream.write(f"# {title}\n\n`{command}`\n\n{page}")
    write_json(folder / f"{name}.json", {"command": command, "machine": facts, **measured})


def table(rows: Sequence[Row]) -> str:
    """A table of at most 80 columns."""
    lines = [f"{'what':40} {'median ms':>9} {'p95 ms':>9} {'min ms':>9} {'repeats':>8}"]
    lines += [
        f"{row.name:40} {row.median:9.3f} {row.p95:9.3f} {row.minimum:9.3f} {row.repeats:8}"
        for row in rows
    ]
    return "\n".join(lines)


def processor() -> str:
    """Name of the processor, as the system reports it."""
    try:
        return processor_in(Path("/proc/cpuinfo").read_text())
    except OSError:
        return platform.processor()


def processor_in(cpuinfo: str) -> str:
    """The name that Linux reports, with the family if the name has no number.

    Rented machines often use one name for processors that differ in speed by a factor of two.
    """
    found = dict(re.findall(r"^(model name|cpu family)\s*: (.+)$", cpuinfo, re.MULTILINE))
    name, family = found.get("model name", platform.processor()), found.get("cpu family")
    return name if family is None or re.search(r"\d", name) else f"{name} family {family}"
