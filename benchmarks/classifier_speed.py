"""Time from a cloud to a name, and of the command's start."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.report import Row, write_report
from circumspect import Classifier, make_furniture, write_ply

REPEATS = 60


def timed(name: str, work: Callable[[], object], repeats: int = REPEATS) -> Row:
    """Median and 95th percentile of `work`, after a warm-up."""
    for _ in range(3):
        work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return Row(name, statistics.median(times), float(np.percentile(times, 95)), repeats)


def rows() -> list[Row]:
    """All measurements, in one run."""
    dense = make_furniture("chair", 3).sampled(32_768, 0)
    sparse = make_furniture("chair", 3).sampled(1_024, 0)
    found = []
    for threads in (1, 2):
        classifier = Classifier.load(threads=threads)
        grids = classifier.recipe.grids(dense)
        views = classifier.recipe.azimuth_views
        plural = "s" if threads > 1 else ""
        found.append(
            timed(
                f"network, {views} views, {threads} thread{plural}",
                lambda grids=grids, classifier=classifier: classifier.probabilities(grids),
            )
        )
    recipe = Classifier.load(threads=1).recipe
    found.append(timed("grids of 32,768 points", lambda: recipe.grids(dense)))
    found.append(timed("fill and grids of 1,024 points", lambda: recipe.grids(sparse)))
    return found + _processes()


def _processes() -> list[Row]:
    program = [sys.executable, "-m", "circumspect.cli.main"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "chair.ply"
        write_ply(file, make_furniture("chair", 3).sampled(32_768, 0))
        commands = {"--help": ["--help"], "classify": ["classify", str(file)]}
        return [
            timed(f"circumspect {name}, whole process", lambda w=words: _run([*program, *w]), 15)
            for name, words in commands.items()
        ]


def _run(words: list[str]) -> None:
    subprocess.run(words, capture_output=True, check=True)


if __name__ == "__main__":
    write_report("classifier_speed", "python -m benchmarks.classifier_speed", rows())
