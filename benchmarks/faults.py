"""Outcomes of scans with faults, as tables by fault.

    python -m benchmarks.faults                      # all faults, a few scans each
    python -m benchmarks.faults --only "robot kidnapped"
    python -m benchmarks.faults --suite pairs        # 30 scans with two faults each

Each scan is one JSON line in `benchmarks/results/faults.jsonl` or `fault_pairs.jsonl` and is not
repeated. The table covers the scans of all faults with the same settings.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fault_pairs import HEAD, pair_jobs, pair_notes, pair_rows
from benchmarks.fault_scenarios import EVERY, FaultJob, run_fault
from benchmarks.provenance import made_by
from benchmarks.report import RESULTS, machine, progress_report
from benchmarks.scan_job import ScanJob
from benchmarks.selection import command_with_flags, records_of_jobs
from circumspect.evaluation.markdown import table
from circumspect.gathering.job_pool import LocalPool, records, run_all

OBJECTS = ("chair-100000", "sofa-100000", "night_stand-100000")
SETTINGS = ("frame_interval", "frames")
"""Flags that determine the scans."""


def rows(found: list[dict[str, Any]]) -> list[list[str]]:
    """One row for each fault, over its scans."""
    lines = []
    for fault in EVERY:
        some = [record for record in found if record["fault"] == fault]
        if some:
            answered = [record for record in some if record["label"] is not None]
            lines.append([
                fault, _correct(answered), _correct([r for r in answered if r.get("confident")]),
                _worst(some, "ate_rmse_m"),
                _while_reliable(some), _mean(some, "reliable"),
                _worst(some, "worst_accurate_m"), _mean(some, "accurate"),
                "; ".join(sorted({str(r["ended"]) for r in some})),
            ])  # fmt: skip
    return lines


def _correct(answered: list[dict[str, Any]]) -> str:
    correct = sum(record["label"] == record.get("true_label") for record in answered)
    return f"{correct} of {len(answered)}"


def _worst(some: list[dict[str, Any]], name: str) -> str:
    known = [1e3 * r[name] for r in some if r.get(name) is not None]
    return f"{max(known):.0f}" if known else "–"


def _while_reliable(some: list[dict[str, Any]]) -> str:
    name = "worst_reliable_sigmas"
    sigmas = [record[name] for record in some if record.get(name) is not None]
    return _worst(some, "worst_reliable_m") + (f" ({max(sigmas):.1f} σ)" if sigmas else "")


def _mean(some: list[dict[str, Any]], name: str) -> str:
    known = [r[name] for r in some if r.get(name) is not None]
    return f"{np.mean(known):.0%}" if known else "–"


def main() -> int:
    """Run missing scans and write the table."""
    given, defaults = _parser().parse_args(), _parser().parse_args([])
    suite = _pairs if given.suite == "pairs" else _singles
    suite(given, defaults)
    return 0


def _singles(given: argparse.Namespace, defaults: argparse.Namespace) -> None:
    path: Path = given.out / "faults.jsonl"
    run_all(
        jobs(given.only or EVERY, given),
        run_fault,
        path,
        LocalPool(given.workers),
        progress_report(),
    )
    command = command_with_flags("python -m benchmarks.faults", given, defaults, SETTINGS)
    found = records_of_jobs(records(path), jobs(EVERY, given))
    write(rows(found), given.out, command, made_by(found))


def _pairs(given: argparse.Namespace, defaults: argparse.Namespace) -> None:
    path: Path = given.out / "fault_pairs.jsonl"
    wanted = pair_jobs(given.frame_interval, given.frames)
    run_all(wanted[: given.scans], run_fault, path, LocalPool(given.workers), progress_report())
    command = command_with_flags(
        "python -m benchmarks.faults --suite pairs", given, defaults, SETTINGS
    )
    found = records_of_jobs(records(path), wanted)
    text = f"`{command}`. {pair_notes(found)} {made_by(found)}\n\n{table(HEAD, pair_rows(found))}"
    _written(given.out / "fault_pairs.md", "Pairs of faults", text)


def jobs(faults: Sequence[str], given: argparse.Namespace) -> list[FaultJob]:
    """A scan of each object with each of some faults; the same arguments give the same scans."""
    return [
        FaultJob(fault, ScanJob("faults", name, 30.0 + 110 * number, number, "normals",
                                given.frame_interval, given.frames))
        for fault in faults
        for number, name in enumerate(OBJECTS)
    ]  # fmt: skip


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--suite", choices=("single", "pairs"), default="single")
    parser.add_argument("--scans", type=int, help="run only the first pairs")
    parser.add_argument("--only", choices=EVERY, action="append")
    parser.add_argument("--frame-interval", type=float, default=0.5, help="between frames [s]")
    parser.add_argument("--frames", type=int, default=4000, help="maximum frames of a scan")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    return parser


def write(lines: list[list[str]], folder: Path, command: str, made: str) -> None:
    """Write `faults.md`."""
    head = [
        "fault", "correct answers", "of confident ones", "ATE [mm], worst",
        "reliable poses, worst error [mm]", "reliable poses",
        "accurate poses, worst error [mm]", "accurate poses", "ended",
    ]  # fmt: skip
    text = (
        f"`{command}`, {len(OBJECTS)} scans a fault ({', '.join(OBJECTS)}). {made}\n\n"
        f"{table(head, lines)}"
    )
    _written(folder / "faults.md", "Faults", text)


def _written(path: Path, title: str, text: str) -> None:
    facts = "".join(f"- {key}: {value}\n" for key, value in machine().items())
    path.write_text(f"# {title}\n\n{text}\n\n{facts}", encoding="utf-8")
    print(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    sys.exit(main())
