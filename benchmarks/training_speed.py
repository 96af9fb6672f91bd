"""Time a step of training, with and without keeping freed memory.

python -m benchmarks.training_speed    # a quarter of an hour on two idle cores

Each row is a process of its own: a setting of the C library holds for the whole process.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, write_page
from circumspect.cli.freed_memory import keep_freed_memory
from circumspect.datasets import GridCache
from circumspect.datasets.furniture_set import furniture_set
from circumspect.evaluation.markdown import table
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect.training.train import train

NETS = ("moon2018", "planes", "voxnet")
PRECISIONS = ("fp32", "bf16")
KEPT, GIVEN_BACK = "kept", "given back"
WARM_UP, STEPS = 3, 8
EACH = 40
"""Objects of each of ten categories; about an eighth of them is held back."""


class Stopwatch:
    """Times steps; a `TrainingObserver`."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self._last: float | None = None

    def preparing(self, done: int, total: int) -> None:
        """Ignore the preparation of grids."""

    def stepped(self, epoch: int, step: int, steps: int, loss: float) -> None:  # noqa: ARG002
        """Record the time since the previous step; stop after enough steps."""
        now = time.perf_counter()
        if self._last is not None:
            self.seconds.append(now - self._last)
        self._last = now
        if len(self.seconds) == WARM_UP + STEPS:
            raise StopIteration

    def finished_epoch(self, row: dict[str, float]) -> None:  # noqa: ARG002
        """Ignore the validation."""
        self._last = None


def step_ms(net: str, precision: str, freed: str) -> dict[str, float]:
    """Median time of a step in this process, with freed memory kept or given back."""
    if freed == KEPT and not keep_freed_memory():
        raise SystemExit("this C library has no setting to keep freed memory")
    settings = TrainingSettings(**{**net_spec(net).training, "net": net})
    settings = replace(settings, precision=precision, epochs=2, passes=2, replicas=2)
    watch, objects = Stopwatch(), furniture_set(EACH)
    with tempfile.TemporaryDirectory() as folder, suppress(StopIteration):
        train(objects, settings, Path(folder) / "run", watch, GridCache(Path(folder) / "grids"))
    steps = watch.seconds[WARM_UP:]
    return {
        "step_ms": 1e3 * float(np.median(steps)),
        "sample_ms": 1e3 * float(np.median(steps)) / settings.batch_size,
        "steps": len(steps),
    }


def main() -> int:
    """Measure all networks and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nets", nargs="+", default=list(NETS))
    parser.add_argument("--one", nargs=3, metavar=("NET", "PRECISION", "FREED"))
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(step_ms(*given.one)))
        return 0
    measured = []
    for net in given.nets:
        for precision in PRECISIONS:
            found = {freed: _in_a_process(net, precision, freed) for freed in (GIVEN_BACK, KEPT)}
            measured.append({"net": net, "precision": precision, **found})
            print(measured[-1], file=sys.stderr)
    rows = [
        [
            row["net"],
            row["precision"],
            *(f"{row[freed]['sample_ms']:.1f}" for freed in (GIVEN_BACK, KEPT)),
            f"{row[GIVEN_BACK]['sample_ms'] / row[KEPT]['sample_ms']:.2f}",
        ]
        for row in measured
    ]
    text = (
        f"A step of training, forward, backward and update, median of {STEPS}; milliseconds an "
        "object. Freed memory is given back to the system, as the C library does by itself, or "
        "kept for the next step, as in `circumspect train`.\n\n"
        + table(["network", "precision", GIVEN_BACK, KEPT, "times as fast"], rows)
    )
    write_page(
        "training_speed", "Training speed", "python -m benchmarks.training_speed", text,
        {"rows": measured}, given.out, {"torch": metadata.version("torch")},
    )  # fmt: skip
    return 0


def _in_a_process(net: str, precision: str, freed: str) -> dict[str, float]:
    words = ["-m", "benchmarks.training_speed", "--one", net, precision, freed]
    done = subprocess.run([sys.executable, *words], stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


if __name__ == "__main__":
    sys.exit(main())
