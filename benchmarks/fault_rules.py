"""Effect of some rules of the tracker in scans with faults that no setting was tuned on.

    python -m benchmarks.fault_rules

Each scan is driven with all rules, and again without each rule that made a difference in it. Each
run is one JSON line in `benchmarks/results/fault_rules.jsonl` and is not repeated.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ablation_rules import RULES
from benchmarks.fault_pairs import outcome
from benchmarks.fault_scenarios import FaultJob, run_fault
from benchmarks.provenance import made_by
from benchmarks.report import RESULTS, progress_report, write_page
from benchmarks.rule_patches import Rule, probed, without
from benchmarks.scan_job import ScanJob
from benchmarks.selection import records_of_jobs
from circumspect.evaluation.markdown import table
from circumspect.gathering.job_pool import LocalPool, records, run_all

NAMES = ("vague poses", "overlap of lost cameras", "slipping wheels", "unknown space")
"""Rules that were introduced because of single scans with faults."""
OBJECTS = (
    "bed-100070", "sofa-100071", "dresser-100072", "table-100073", "desk-100074",
    "night_stand-100075",
)  # fmt: skip
"""Variants that no other benchmark uses."""
FAULTS = (
    "odometry gone from the start", "odometry stuck", "clock of the images 1 s behind",
    "robot kidnapped", "robot blocked for 20 s", "object from wall to wall",
)  # fmt: skip
SEED = 70
BAD_M = 0.06
"""Scans with a `reliable` pose whose error is larger [m] are counted."""


@dataclass(frozen=True)
class RuleJob:
    """A scan with a fault, with all rules or without one.

    Attributes:
        fault: The scan.
        rule: Rule that is switched off; empty for none.
    """

    fault: FaultJob
    rule: str = ""

    @property
    def key(self) -> str:
        """Unique name."""
        return f"{self.rule or 'all rules'}/{self.fault.key}"


def run_job(job: RuleJob) -> dict[str, Any]:
    """Run a scan; JSON types. With all rules, the record lists those that make a difference."""
    rules = rules_of(NAMES)
    if job.rule:
        with without(rules_of((job.rule,))):
            return {**run_fault(job.fault), "key": job.key, "rule": job.rule}
    with probed(rules) as active:
        found = run_fault(job.fault)
    return {**found, "key": job.key, "rule": "", "active": sorted(active)}


def rules_of(names: Sequence[str]) -> tuple[Rule, ...]:
    """Rules by name."""
    return tuple(rule for rule in RULES if rule.name in names)


def fault_jobs(frame_interval: float, frames: int) -> list[FaultJob]:
    """Each object with each fault, from random starts."""
    found = []
    for number, (name, fault) in enumerate((o, f) for o in OBJECTS for f in FAULTS):
        start = float(np.round(np.random.default_rng([SEED, number]).uniform(0, 360), 1))
        scan = ScanJob("fault_rules", name, start, number, "normals", frame_interval, frames)
        found.append(FaultJob(fault, scan))
    return found


def rows(found: list[dict[str, Any]]) -> list[list[str]]:
    """One row with all rules, and one without each; scans without a difference are unchanged."""
    whole = [record for record in found if not record["rule"]]
    lines = [_line("all rules", "", whole)]
    for name in NAMES:
        changed = {_scan(record): record for record in found if record["rule"] == name}
        replaced = [changed.get(_scan(record), record) for record in whole]
        lines.append(_line(f"without {name}", str(len(changed)), replaced))
    return lines


def _scan(record: dict[str, Any]) -> str:
    return f"{record['fault']}/{record['object']}"


def _line(title: str, active: str, some: list[dict[str, Any]]) -> list[str]:
    worst = [r["worst_reliable_m"] for r in some if r.get("worst_reliable_m") is not None]
    errors = [r["ate_rmse_m"] for r in some if r.get("ate_rmse_m") is not None]
    outcomes = [outcome(record) for record in some]
    return [
        title, active, f"{1e3 * np.median(errors):.1f}, {1e3 * max(errors):.0f}",
        f"{1e3 * max(worst):.0f}", str(sum(one > BAD_M for one in worst)),
        str(sum(r["ended"] == "once round the object" for r in some)),
        str(sum("and correct" in one for one in outcomes)),
        str(sum("and wrong" in one for one in outcomes)),
    ]  # fmt: skip


HEAD = [
    "rules", "scans changed", "ATE [mm], median and worst", "worst reliable pose [mm]",
    "scans with one off by more than 60 mm", "once round", "confident and correct",
    "confident and wrong",
]  # fmt: skip


def main() -> int:
    """Run missing scans and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frame-interval", type=float, default=0.5, help="between frames [s]")
    parser.add_argument("--frames", type=int, default=4000, help="maximum frames of a scan")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    path, pool = given.out / "fault_rules.jsonl", LocalPool(given.workers)
    whole = [RuleJob(fault) for fault in fault_jobs(given.frame_interval, given.frames)]
    done = {
        record["key"]: record for record in run_all(whole, run_job, path, pool, progress_report())
    }
    parts = [
        RuleJob(job.fault, name)
        for job in whole
        for name in NAMES
        if name in done.get(job.key, {}).get("active", [])
    ]
    run_all(parts, run_job, path, pool, progress_report())
    found = records_of_jobs(records(path), [*whole, *parts])
    text = (
        f"{len(whole)} scans: {len(OBJECTS)} pieces of furniture that no setting was tuned on, "
        f"each with {len(FAULTS)} faults ({', '.join(FAULTS)}). Scans in which a rule makes no "
        f"difference count unchanged. {made_by(found)}\n\n{table(HEAD, rows(found))}"
    )
    command = "python -m benchmarks.fault_rules"
    write_page("fault_rules", "Rules against faults", command, text, {"rows": rows(found)},
               given.out)  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
