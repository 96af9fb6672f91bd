"""Memory over a long scan: `python -m benchmarks.scan_memory` drives on for 30 minutes.

The robot goes round and round one object and never finds that it has seen enough.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchmarks.asked import command_with
from benchmarks.report import RESULTS, write_page
from benchmarks.scan_job import ScanJob, prepared
from circumspect.evaluation.markdown import table
from circumspect.planning import CirclePlanner, Finished, NextView, PlannerInput, ViewPlanner
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.tracking import Tracker

PAGE = os.sysconf("SC_PAGE_SIZE")
TELL_EVERY_S = 120.0
"""Robot's time between two rows [s]."""
SETTINGS = ("minutes", "object")
"""Flags that say what is driven."""


@dataclass(frozen=True)
class RestlessPlanner(ViewPlanner):
    """Drives round the object for ever."""

    circle: CirclePlanner = field(default_factory=CirclePlanner)

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """A circle planner that forgets where it was."""
        return self.circle.next_view(replace(planner_input, visited=planner_input.visited[-1:]))

    def check_finished(self, planner_input: PlannerInput) -> Finished | None:  # noqa: ARG002
        """Never."""
        return None


@dataclass(frozen=True)
class Sample:
    """Memory and speed at a moment.

    Attributes:
        frames: So far.
        stamp: Robot's time [s].
        keyframes: That the map is made of.
        resident_mb: Memory of the process.
        frame_ms: Median time a frame since the sample before.
    """

    frames: int
    stamp: float
    keyframes: int
    resident_mb: float
    frame_ms: float


class MemoryWatch:
    """Takes samples; a `PipelineObserver`."""

    def __init__(self, keyframes: Callable[[], int]) -> None:
        """Count keyframes by what is given."""
        self._keyframes = keyframes
        self.samples: list[Sample] = []
        self._spent: list[float] = []

    def on_step(self, step: RecognitionStep) -> None:
        self._spent.append(sum(step.milliseconds.values()))
        last = self.samples[-1].stamp if self.samples else -TELL_EVERY_S
        if step.stamp - last >= TELL_EVERY_S:
            self._take(step)

    def on_end(self, result: RecognitionResult) -> None:
        if result.last is not None:
            self._take(result.last)

    def _take(self, step: RecognitionStep) -> None:
        median = float(np.median(self._spent)) if self._spent else 0.0
        sample = Sample(step.index + 1, step.stamp, self._keyframes(), resident_mb(), median)
        self.samples.append(sample)
        self._spent.clear()
        print(self.samples[-1], file=sys.stderr)


def resident_mb() -> float:
    """Resident memory of this process, by Linux's own count."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * PAGE / 1e6


def main() -> int:
    """Drive, sample, write."""
    arguments, usual = _parser().parse_args(), _parser().parse_args([])
    job = ScanJob("memory", arguments.object, 0.0, 0, frames=round(arguments.minutes * 60 / 0.5))
    parts = prepared(job, RestlessPlanner())
    tracker = parts.pipeline.tracker.estimator
    assert isinstance(tracker, Tracker)
    watch = MemoryWatch(lambda: len(tracker.keyframes))
    start = time.monotonic()
    parts.scan.run((watch,))
    rows = [
        [f"{s.stamp / 60:.0f}", *map(str, (s.frames, s.keyframes)),
         f"{s.resident_mb:.0f}", f"{s.frame_ms:.0f}"]
        for s in watch.samples
    ]  # fmt: skip
    text = (
        f"Round and round {arguments.object}, a frame each 0.5 s of the robot's time.\n\n"
        + table(["minutes", "frames", "keyframes", "resident [MB]", "frame [ms], median"], rows)
        + f"\n\nIt ended: {parts.scan.ended}. {(time.monotonic() - start) / 60:.0f} min of work."
    )
    command = command_with("python -m benchmarks.scan_memory", arguments, usual, SETTINGS)
    measured = {"samples": [vars(sample) for sample in watch.samples]}
    write_page("scan_memory", "Memory over a long scan", command, text, measured, arguments.out)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0, help="of the robot's time")
    parser.add_argument("--object", default="chair-100000")
    parser.add_argument("--out", type=Path, default=RESULTS)
    return parser


if __name__ == "__main__":
    sys.exit(main())
