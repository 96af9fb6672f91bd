"""Time of the shipped classifiers, of the paper's network, and of whole commands."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from functools import partial
from itertools import product
from pathlib import Path

from benchmarks.report import Row, timed, write_report
from circumspect import Classifier, make_furniture, write_ply
from circumspect.classification.shipped import MODELNET10, ROBOT
from circumspect.export import export_onnx
from circumspect.nets import NETS, Checkpoint, build_net


def rows() -> list[Row]:
    """All measurements, in one run."""
    dense = make_furniture("chair", 3).sampled(32_768, 0)
    sparse = make_furniture("chair", 3).sampled(1_024, 0)
    found = []
    for name, threads in product((MODELNET10, ROBOT), (1, 2)):
        classifier = Classifier.load(name, threads)
        inputs = classifier.input_spec.inputs(dense)
        views = classifier.input_spec.azimuth_views
        plural = "s" if threads > 1 else ""
        found.append(
            timed(
                f"{name}, {views} views, {threads} thread{plural}",
                partial(classifier.probabilities, inputs),
            )
        )
    found.append(_table_1())
    input_spec = Classifier.load(MODELNET10, threads=1).input_spec
    found.append(timed("grids of 32,768 points", partial(input_spec.inputs, dense)))
    found.append(timed("fill and grids of 1,024 points", partial(input_spec.inputs, sparse)))
    return found + _processes()


def _table_1() -> Row:
    """The paper's network with random weights; its time does not depend on them."""
    classes, input_spec = Classifier.load(MODELNET10).classes, NETS["moon2018"].input_spec
    weights = build_net("moon2018", len(classes), input_spec).state_dict()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "moon2018.onnx"
        export_onnx([Checkpoint("moon2018", classes, input_spec, weights)], file)
        classifier = Classifier.load(file, threads=1)
    inputs = classifier.input_spec.inputs(make_furniture("chair", 3).sampled(32_768, 0))
    name = "the paper's network (Table 1), 1 thread"
    return timed(name, partial(classifier.probabilities, inputs), seconds=5.0)


def _processes() -> list[Row]:
    program = [sys.executable, "-m", "circumspect"]
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


def main() -> None:
    """Measure, print, and write the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    found = rows()
    ours, table_1 = (
        next(row for row in found if word in row.name) for word in (MODELNET10, "Table 1")
    )
    median, fastest = table_1.median / ours.median, table_1.minimum / ours.minimum
    note = (
        f"{MODELNET10}, in eight bits and with all its views, is {median:.1f} times as fast as the "
        f"paper's network in floating point ({fastest:.1f} times by the minima)."
    )
    write_report("classifier_speed", "python -m benchmarks.classifier_speed", found, note)


if __name__ == "__main__":
    main()
