"""Time from a cloud to a name, and of the command's start."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

from benchmarks.report import Row, timed, write_report
from circumspect import Classifier, make_furniture, write_ply


def rows() -> list[Row]:
    """All measurements, in one run."""
    dense = make_furniture("chair", 3).sampled(32_768, 0)
    sparse = make_furniture("chair", 3).sampled(1_024, 0)
    found = []
    for threads in (1, 2):
        classifier = Classifier.load(threads=threads)
        inputs = classifier.recipe.inputs(dense)
        views = classifier.recipe.azimuth_views
        plural = "s" if threads > 1 else ""
        found.append(
            timed(
                f"network, {views} views, {threads} thread{plural}",
                partial(classifier.probabilities, inputs),
            )
        )
    recipe = Classifier.load(threads=1).recipe
    found.append(timed("grids of 32,768 points", partial(recipe.inputs, dense)))
    found.append(timed("fill and grids of 1,024 points", partial(recipe.inputs, sparse)))
    return found + _processes()


def _processes() -> list[Row]:
    program = [sys.executable, "-m", "circumspect.cli.main"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "chair.ply"
        write_ply(file, make_furniture("chair", 3).sampled(32_768, 0))
        commands = {"--help": ["--help"], "classify": ["classify", str(file)]}
        return [
            timed(
                f"circumspect {name}, whole process", partial(_run, [*program, *words]), seconds=5.0
            )
            for name, words in commands.items()
        ]


def _run(words: list[str]) -> None:
    subprocess.run(words, capture_output=True, check=True)


if __name__ == "__main__":
    write_report("classifier_speed", "python -m benchmarks.classifier_speed", rows())
