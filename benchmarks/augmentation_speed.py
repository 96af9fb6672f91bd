"""Time of a training sample: augmented complete clouds and simulated scans.

    python -m benchmarks.augmentation_speed    # two minutes

Both are created once and cached; an epoch reads the cache. The objects are procedural furniture, so
no data set is needed.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import torch

from benchmarks.report import Row, timed_in_turn, write_report
from circumspect.classification import GridSpec
from circumspect.datasets import GridCache
from circumspect.datasets.furniture_set import furniture_set
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect.training.batches import DrawnBatches, Samples
from circumspect.training.scan_data import scan_data
from circumspect.training.training_data import TrainingData, object_data

EACH, REPLICAS, BATCH = 12, 4, 32
CLOUDS, SCANS = "complete clouds", "simulated scans"
NOTES = f"""\
made: time of one sample, all cores, mean of {REPLICAS} variants of {{count}} objects
read: time per sample of a batch of {BATCH} from the cache, as in an epoch
"""


def rows() -> list[Row]:
    """All measurements."""
    objects, spec = furniture_set(EACH), net_spec("planes")
    settings = TrainingSettings(replicas=REPLICAS, catalogue=0.0, validation=False)

    def nothing(done: int, count: int) -> None:
        """Show no progress."""

    cpu, input_spec = torch.device("cpu"), spec.input_spec
    assert isinstance(input_spec, GridSpec)
    of_scans = replace(input_spec, visibility=True, metric=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def complete() -> Samples:
            cache = GridCache(folder)
            return _samples_of(object_data(objects, settings, input_spec, cache, cpu, nothing))

        def scanned() -> Samples:
            found = scan_data(objects, (), settings, of_scans, cpu, nothing, folder)
            return _samples_of(found)

        clouds, made_clouds = _timed_once(complete)
        scans, made_scans = _timed_once(scanned)
    count = len(objects) * REPLICAS
    found = [
        _single(f"{CLOUDS}, made", made_clouds / count),
        _single(f"{SCANS}, made", made_scans / count),
    ]
    read = timed_in_turn(
        {
            f"{name}, read": partial(_batch, samples, np.random.default_rng(0))
            for name, samples in ((CLOUDS, clouds), (SCANS, scans))
        }
    )
    return found + [_per_sample(row) for row in read]


def _samples_of(data: TrainingData) -> Samples:
    assert isinstance(data.batches, DrawnBatches)
    return data.batches.samples


def _timed_once(make: Callable[[], Samples]) -> tuple[Samples, float]:
    start = time.perf_counter()
    return make(), 1e3 * (time.perf_counter() - start)


def _single(name: str, milliseconds: float) -> Row:
    return Row(name, milliseconds, milliseconds, milliseconds, 1)


def _per_sample(row: Row) -> Row:
    return Row(row.name, row.median / BATCH, row.p95 / BATCH, row.minimum / BATCH, row.repeats)


def _batch(samples: Samples, rng: np.random.Generator) -> None:
    chosen = rng.choice(len(samples.chances), BATCH)
    samples.inputs(chosen, rng.integers(REPLICAS, size=BATCH), rng)


def main() -> None:
    """Measure, print, and write the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    notes = NOTES.format(count=10 * EACH)
    write_report("augmentation_speed", "python -m benchmarks.augmentation_speed", rows(), notes)


if __name__ == "__main__":
    main()
