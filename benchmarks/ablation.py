"""Ablation of the tracker: recorded frames, tracked without one part at a time.

    python -m benchmarks.ablation                       # all data; hours
    python -m benchmarks.ablation --every 6 --every-fault 3
    python -m benchmarks.ablation --timing              # milliseconds, on an idle machine
    python -m benchmarks.ablation --tables              # only from existing records

Each run is one JSON line in `runs/ablation.jsonl` and is not repeated. `benchmarks.recorded_scans`
records the scans. The tables cover the recordings on which every variant was run.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ablation_data import FAULTS, GROUPS, Source, loaded, real, scans
from benchmarks.ablation_rules import RULES
from benchmarks.open_loop import OpenLoopTracker, run_open_loop
from benchmarks.open_loop_trackers import GicpWithOdometry, KernelOnly, OwnTracker, WheelsOnly
from benchmarks.provenance import made_by, provenance
from benchmarks.recorded_scans import FOLDER
from benchmarks.report import RESULTS, progress_report, write_page
from benchmarks.rule_patches import probed, without
from benchmarks.selection import command_with_flags
from circumspect.errors import CircumspectError
from circumspect.gathering.job_pool import LocalPool, records, run_all
from circumspect.tracking import TrackingSettings

NAME = "ablation"
DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
RECORDS, TIMES = "ablation.jsonl", "ablation_timing.jsonl"
SETTINGS = ("every", "every_fault", "frames", "scan_frames")
"""Flags that determine what is measured."""
ALL, NONE = "all", "all off"
BASELINES: dict[str, Callable[[TrackingSettings], OpenLoopTracker]] = {
    "wheels only": WheelsOnly,
    "small_gicp, odometry": GicpWithOdometry,
    "kernel, odometry": KernelOnly,
}
BY_NAME = {rule.name: rule for rule in RULES}
VARIANTS = (ALL, *BY_NAME, NONE, *BASELINES)
KIDNAPPED = "robot_kidnapped"

Record = dict[str, Any]
Results = Mapping[str, Mapping[str, Record]]
"""Records by recording, then by variant."""


@dataclass(frozen=True)
class AblationJob:
    """A tracker on a recording.

    Attributes:
        variant: One of `VARIANTS`: all rules, the rule that is switched off, or a baseline.
        source: The recording.
        timed: Whether the run only measures time.
    """

    variant: str
    source: Source
    timed: bool = False

    @property
    def key(self) -> str:
        """Unique name."""
        return f"{self.variant}/{self.source.key}"

    @property
    def probed(self) -> bool:
        """Whether the run records which rules make a difference."""
        return self.variant == ALL and not self.timed


def run(job: AblationJob) -> Record:
    """Track a recording."""
    frames, truth = loaded(job.source)
    head = {"key": job.key, "variant": job.variant, "source": job.source.key, "made": provenance()}
    tracker = BASELINES.get(job.variant, OwnTracker)(job.source.settings)
    try:
        with _switched(job) as active:
            result = run_open_loop(tracker, frames, truth)
    except (CircumspectError, ValueError) as error:  # LinAlgError is a ValueError
        return {**head, "error": f"{type(error).__name__}: {error}"}
    return {**head, **result.as_dict(), **({"active": sorted(active)} if job.probed else {})}


def _switched(job: AblationJob) -> AbstractContextManager[Any]:
    if job.probed:
        return probed(RULES)
    if job.variant == NONE:
        return without(RULES)
    return without([BY_NAME[job.variant]] if job.variant in BY_NAME else [])


def measure(sources: Sequence[Source], path: Path, workers: int) -> None:
    """Run all variants, except for rules that make no difference on a recording."""
    progress = progress_report()
    full = run_all(
        [AblationJob(ALL, source) for source in sources], run, path, LocalPool(workers), progress
    )
    active = {record["source"]: set(record.get("active", ())) for record in full}
    others = [AblationJob(v, source) for source in sources for v in (NONE, *BASELINES)]
    acting = [
        AblationJob(name, source)
        for source in sources
        for name in BY_NAME
        if name in active.get(source.key, ())
    ]
    run_all([*others, *acting], run, path, LocalPool(workers), progress_report())


def results(found: Sequence[Record], sources: Sequence[Source]) -> Results:
    """Records of the recordings on which every variant was run."""
    by_source: dict[str, dict[str, Record]] = {}
    for record in found:
        by_source.setdefault(record["source"], {})[record["variant"]] = record
    complete = {}
    for source in sources:
        by_variant = by_source.get(source.key, {})
        full = by_variant.get(ALL)
        if full is None:
            continue
        idle = {name: full for name in BY_NAME if name not in full.get("active", ())}
        by_variant = {**idle, **by_variant}
        if set(VARIANTS) <= set(by_variant):
            complete[source.key] = by_variant
    return complete


HEAD = ("", "ATE", "max", "final", "worst", "σ", "NEES", "rel.", "held", "kidn.", "acts")
WIDTHS = (20, 6, 6, 6, 6, 6, 6, 5, 6, 6, 6)
COLUMNS = """ATE: root mean square position error of live poses, aligned rigidly [mm], median
over recordings; max: the largest; final: median after all corrections; worst: largest error of a
reliable pose [mm]; σ: largest such error in standard deviations (errors above 10 mm only); NEES:
median (5.3 expected); rel.: share of reliable poses; held: recordings whose last 20 poses are
reliable and within 50 mm; kidn.: the same for kidnapped robots; acts: recordings whose figures
differ from by_variant of "all" as printed. Baselines call every pose reliable."""


def row(variant: str, chosen: Sequence[Mapping[str, Record]]) -> dict[str, Any]:
    """Figures of a variant over recordings."""
    runs = [one[variant] for one in chosen if "error" not in one[variant]]
    held = [record["recovered"] for record in runs]
    kidnapped = [r["recovered"] for r in runs if r["source"].startswith(KIDNAPPED)]

    def over(name: str, how: Callable[[list[float]], Any]) -> float | None:
        known = [record[name] for record in runs if record[name] is not None]
        return float(how(known)) if known else None

    return {
        "variant": variant,
        "ate_mm": over("ate_mm", np.median),
        "max_ate_mm": over("ate_mm", max),
        "final_ate_mm": over("final_ate_mm", np.median),
        "worst_reliable_mm": over("worst_reliable_mm", max),
        "worst_reliable_sigmas": over("worst_reliable_sigmas", max),
        "nees": over("nees", np.median),
        "reliable": over("reliable", np.mean),
        "held": (sum(held), len(held)),
        "kidnapped": (sum(kidnapped), len(kidnapped)),
        "acts": (sum(_differs(one[variant], one[ALL]) for one in chosen), len(chosen)),
        "errors": sorted({one[variant]["error"] for one in chosen if "error" in one[variant]}),
    }


FIGURES = ("ate_mm", "final_ate_mm", "worst_reliable_mm", "worst_reliable_sigmas", "nees")


def _differs(one: Record, other: Record) -> bool:
    """Whether two runs differ by more than the tables' precision."""
    first, second = map(_printed, (one, other))
    return first != second


def _printed(record: Record) -> tuple[Any, ...]:
    if "error" in record:
        return (record["error"],)
    figures = (_number(record[name]) for name in FIGURES)
    return (*figures, f"{record['reliable']:.0%}", record["recovered"])


def cells(found: Mapping[str, Any]) -> list[str]:
    """A line of a table."""
    figures = (
        "ate_mm", "max_ate_mm", "final_ate_mm", "worst_reliable_mm", "worst_reliable_sigmas",
        "nees",
    )  # fmt: skip
    share = found["reliable"]
    return [
        found["variant"],
        *(_number(found[name]) for name in figures),
        "–" if share is None else f"{share:.0%}",
        *(
            "{}/{}".format(*found[name]) if found[name][1] else "–"
            for name in ("held", "kidnapped")
        ),
        "{}/{}".format(*found["acts"]),
    ]


def _number(value: float | None) -> str:
    """A number in at most five characters."""
    if value is None:
        return "–"
    if value < 99.95:
        return f"{value:.1f}"
    return (
        f"{value:.0f}" if value < 99999.5 else f"{value:.0e}".replace("e+0", "e").replace("+", "")
    )


def fixed_width(lines: Sequence[Sequence[str]], widths: Sequence[int]) -> str:
    """A table that fits 80 columns."""
    padded = [
        line[0].ljust(widths[0])
        + "".join(cell.rjust(width) for cell, width in zip(line[1:], widths[1:], strict=True))
        for line in lines
    ]
    return "```\n" + "\n".join(padded) + "\n```"


def timing_table(found: Sequence[Record]) -> str:
    """Median milliseconds of a frame; a column for each recording."""
    sources = sorted({record["source"] for record in found})
    times = {(r["variant"], r["source"]): r.get("milliseconds") for r in found}
    head = ["", *(source.split("/")[0].split("-")[0][:11] for source in sources)]
    lines = [
        [variant, *(_number(times.get((variant, source))) for source in sources)]
        for variant in VARIANTS
    ]
    return fixed_width([head, *lines], [20, *(12 for _ in sources)])


def page(found: Results, sources: Sequence[Source], times: Sequence[Record]) -> tuple[str, Record]:
    """The text and its figures."""
    parts, figures = [COLUMNS], {}
    for group in GROUPS:
        chosen = [found[s.key] for s in sources if s.group == group and s.key in found]
        if not chosen:
            continue
        rows = [row(variant, chosen) for variant in VARIANTS]
        frames = sum(one[ALL]["frames"] for one in chosen)
        names = [s.name for s in sources if s.group == group and s.key in found]
        of = f"Scans: {', '.join(names)}. " if group == FAULTS else ""
        parts.append(f"## {group}\n\n{of}Recordings: {len(chosen)}, frames: {frames}.")
        parts.append(fixed_width([HEAD, *map(cells, rows)], WIDTHS))
        parts += [f"{r['variant']}: {error}" for r in rows for error in r["errors"]]
        figures[group] = {"recordings": names, "frames": frames, "rows": rows}
    if times:
        parts += ["## Time\n\nMedian milliseconds of a frame.", timing_table(times)]
    notes = "\n".join(f"- {rule.name}: {rule.neutral}" for rule in RULES)
    parts.append(f"## Parts\n\nEffect of switching each part off:\n\n{notes}")
    return "\n\n".join(parts), figures


def main() -> int:
    """Run missing variants and write the tables."""
    given, defaults = _parser().parse_args(), _parser().parse_args([])
    sources = [
        *scans(given.scans, given.every, given.every_fault, given.scan_frames),
        *real(given.data, given.frames),
    ]
    if given.timing:
        firsts = {source.group: source for source in reversed(sources)}
        timed = [AblationJob(v, source, True) for source in firsts.values() for v in VARIANTS]
        run_all(timed, run, given.runs / TIMES, LocalPool(1), progress_report())
    elif not given.tables:
        measure(sources, given.runs / RECORDS, given.workers)
    found = results(records(given.runs / RECORDS), sources)
    text, figures = page(found, sources, records(given.runs / TIMES))
    made = made_by(record for one in found.values() for record in one.values())
    command = command_with_flags("python -m benchmarks.ablation", given, defaults, SETTINGS)
    title = "Ablation of the tracker"
    write_page(NAME, title, command, f"{made}\n\n{text}", {"groups": figures}, given.out)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="use every N-th furniture scan")
    parser.add_argument("--every-fault", type=int, default=1, help="use every N-th fault scan")
    parser.add_argument("--frames", type=int, help="maximum frames of a real recording")
    parser.add_argument("--scan-frames", type=int, help="maximum frames of a recorded scan")
    parser.add_argument("--scans", type=Path, default=FOLDER, help="folder of recorded scans")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of real recordings")
    parser.add_argument("--runs", type=Path, default=FOLDER.parent, help="folder of the records")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument(
        "--timing", action="store_true", help="measure time on one recording of each group"
    )
    parser.add_argument("--tables", action="store_true", help="only write the tables")
    return parser


if __name__ == "__main__":
    sys.exit(main())
