"""Scans with two faults at the same time: no answer may be confident and wrong."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from typing import Any

import numpy as np

from benchmarks.fault_scenarios import EVERY, FAULTS, GIANT, FaultJob
from benchmarks.scan_job import ScanJob
from circumspect.furniture import CATEGORIES

PAIRS = 30
SEED = 45
FIRST_VARIANT = 100_020
"""First variant of the furniture; no other benchmark uses these variants."""
HEAD = ["faults", "object", "answer", "outcome", "ATE [mm]", "reliable poses", "ended"]


def pairs() -> list[tuple[str, str]]:
    """Random pairs of faults in which all faults are about equally frequent."""
    known = [fault for fault in EVERY if fault not in ("none", GIANT)]
    # A scan has one world, so that at most one fault of a pair changes the world.
    possible = [pair for pair in combinations(known, 2) if any(fault in FAULTS for fault in pair)]
    drawn = [possible[n] for n in np.random.default_rng(SEED).permutation(len(possible))]
    used, chosen = Counter[str](), list[tuple[str, str]]()
    for _ in range(PAIRS):
        pair = min(drawn, key=lambda pair: used[pair[0]] + used[pair[1]])
        drawn.remove(pair)
        used.update(pair)
        chosen.append(pair)
    return chosen


def pair_jobs(frame_interval: float, frames: int) -> list[FaultJob]:
    """A scan with each pair; the same arguments give the same scans."""
    found = []
    for number, (first, second) in enumerate(pairs()):
        name = f"{CATEGORIES[number % len(CATEGORIES)]}-{FIRST_VARIANT + number // len(CATEGORIES)}"
        start = float(np.round(np.random.default_rng([SEED, number]).uniform(0, 360), 1))
        scan = ScanJob("fault_pairs", name, start, number, "normals", frame_interval, frames)
        found.append(FaultJob(first, scan, second))
    return found


def pair_rows(found: list[dict[str, Any]]) -> list[list[str]]:
    """One row for each scan."""
    return [
        [
            record["fault"], record["object"], record["label"] or "none", outcome(record),
            _figure(record.get("ate_rmse_m"), "{:.0f}", 1e3),
            _figure(record.get("reliable"), "{:.0%}"), str(record["ended"]),
        ]
        for record in found
    ]  # fmt: skip


def pair_notes(found: list[dict[str, Any]]) -> str:
    """A sentence on the number of confident wrong answers."""
    wrong = sum(outcome(record) == "confident and wrong" for record in found)
    confident = sum(bool(record.get("confident")) for record in found)
    verdict = "No wrong confident answer" if wrong == 0 else f"{wrong} wrong confident answers"
    return f"{verdict}: {len(found)} of {PAIRS} scans, {confident} confident answers."


def outcome(record: dict[str, Any]) -> str:
    """Whether the answer was confident, and correct."""
    if record["label"] is None:
        return "no answer"
    correct = record["label"] == record.get("true_label")
    if not record.get("confident"):
        return "correct, not confident" if correct else "wrong, not confident"
    return "confident and correct" if correct else "confident and wrong"


def _figure(value: float | None, form: str, factor: float = 1.0) -> str:
    return "–" if value is None else form.format(factor * value)
