"""Memory during a long scan: `python -m benchmarks.scan_memory` drives for 30 minutes.

The robot circles one object and never finishes the scan.
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

from benchmarks.report import RESULTS, write_page
from benchmarks.scan_job import ScanJob, prepared
from benchmarks.selection import command_with_flags
from circumspect.evaluation.markdown import table
from circumspect.planning import CirclePlanner, Finished, NextView, PlannerInput, ViewPlanner
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.tracking import Tracker

PAGE = os.sysconf("SC_PAGE_SIZE")
SAMPLE_INTERVAL_S = 120.0
"""Robot's time between two samples [s]."""
SETTINGS = ("minutes", "object")
"""Flags that determine the scan."""


@dataclass(frozen=True)
class RestlessPlanner(ViewPlanner):
    """Circles the object without end."""

    circle: CirclePlanner = field(default_factory=CirclePlanner)

    def next_view(self, planner_input: PlannerInput) -> NextView | Finished:
        """The next view of a circle planner without past poses."""
        return self.circle.next_view(replace(planner_input, visited=planner_input.visited[-1:]))

    def check_finished(self, planner_input: PlannerInput) -> Finished | None:  # noqa: ARG002
        """Never finish."""
        return None


@dataclass(frozen=True)
class Sample:
    """Memory and speed at a moment.

    Attributes:
        frames: Number of frames so far.
        stamp: Robot's time [s].
        keyframes: Number of keyframes of the map.
        resident_mb: Memory of the process.
        frame_ms: Median time of a frame since the previous sample.
    """

    frames: int
    stamp: float
    keyframes: int
    resident_mb: float
    frame_ms: float


class MemoryWatch:
    """Takes samples; a `PipelineObserver`."""

    def __init__(self, keyframes: Callable[[], int]) -> None:
        """Start without samples.

        Args:
            keyframes: Returns the number of keyframes.
        """
        self._keyframes = keyframes
        self.samples: list[Sample] = []
        self._spent: list[float] = []

    def on_step(self, step: RecognitionStep) -> None:
        """Take a sample if one is due."""
        self._spent.append(sum(step.milliseconds.values()))
        last = self.samples[-1].stamp if self.samples else -SAMPLE_INTERVAL_S
        if step.stamp - last >= SAMPLE_INTERVAL_S:
            self._take(step)

    def on_end(self, result: RecognitionResult) -> None:
        """Take a last sample."""
        if result.last is not None:
            self._take(result.last)

    def _take(self, step: RecognitionStep) -> None:
        median = float(np.median(self._spent)) if self._spent else 0.0
        sample = Sample(step.index + 1, step.stamp, self._keyframes(), resident_mb(), median)
        self.samples.append(sample)
        self._spent.clear()
        print(self.samples[-1], file=sys.stderr)


def resident_mb() -> float:
    """Resident memory of this process, as Linux reports it [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * PAGE / 1e6


def main() -> int:
    """Run the scan and write the samples."""
    arguments, defaults = _parser().parse_args(), _parser().parse_args([])
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
        f"Circles round {arguments.object}, a frame every 0.5 s of the robot's time.\n\n"
        + table(["minutes", "frames", "keyframes", "resident [MB]", "frame [ms], median"], rows)
        + f"\n\nEnd reason: {parts.scan.ended}. Computing took "
        f"{(time.monotonic() - start) / 60:.0f} min."
    )
    command = command_with_flags("python -m benchmarks.scan_memory", arguments, defaults, SETTINGS)
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
