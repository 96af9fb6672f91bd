"""Scaling of sets of scans and grids: unit costs, workers, a lost node and memory.

    python -m benchmarks.scale                 # about half an hour on two cores
    python -m benchmarks.scale --part memory

`docs/scale.md` extrapolates to millions of objects.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.large_bags import high_water_mb
from benchmarks.report import RESULTS, write_page
from benchmarks.scans import DATA
from circumspect import __version__
from circumspect.classification import GridSpec
from circumspect.datasets.gathered_set import read_manifest
from circumspect.datasets.gathered_verification import verify_gathered
from circumspect.datasets.set_store import SetStore
from circumspect.datasets.shard_file import Rows, ShardHead, write_shard
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.evaluation.markdown import table
from circumspect.gathering import GatherSettings, LocalPool, objects_for
from circumspect.gathering.conversion import ConversionSettings, convert
from circumspect.gathering.gather import gather
from circumspect.gathering.set_place import SetFolder
from circumspect.nets.registry import net_spec
from circumspect.storage import write_json
from circumspect.training import TrainingSettings

WORKERS = (1, 2, 4)
OBJECTS = 2
"""Objects of each class; each is scanned once."""
SCANS = GatherSettings(
    ("bed", "chair", "sofa", "table"), OBJECTS, 0, (0.0,), (), frame_interval=3.0
)
VARIANTS = 4
"""Variants of each converted object."""
SET_SIZES = (10_000, 100_000, 1_000_000)
BATCH = 64
SHARD = 4096
STORE = 100 << 20
"""Memory of a Ray node's object store [bytes]."""
LOST_AFTER = 3
"""Scans after which a node is killed."""


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def scans(folder: Path, given: argparse.Namespace) -> dict[str, Any]:
    """Seconds per scan with several workers, and the processor time of a scan."""
    del given
    objects, rows = objects_for(SCANS), []
    for workers in WORKERS:
        at = folder / f"scans-{workers}"
        work = LocalPool(workers)
        seconds = _timed(lambda at=at, work=work: gather(SetFolder(at), SCANS, objects, work))
        found = read_manifest(at)
        rows.append({
            "workers": workers, "seconds": seconds / len(found),
            "processor_s": float(np.mean([scan.quality["processor_s"] for scan in found])),
            "bytes": _size(at) / len(found), "scans": len(found),
            "frames": float(np.mean([scan.quality["frames"] for scan in found])),
        })  # fmt: skip
    return {"rows": rows}


def conversion(folder: Path, given: argparse.Namespace) -> dict[str, Any]:
    """Variants per second with several workers, and their size."""
    settings = TrainingSettings(**{**net_spec("planes").training, "net": "planes"})
    input_spec = net_spec("planes").input_spec
    assert isinstance(input_spec, GridSpec)
    conversion_settings = ConversionSettings(
        input_spec, settings.changes(input_spec.margin), VARIANTS, 1024
    )
    rows = []
    for workers in WORKERS:
        at = folder / f"shards-{workers}"
        counts: dict[str, int] = {}
        seconds = _timed(
            lambda at=at, workers=workers, counts=counts: counts.update(
                convert(given.data, str(at), conversion_settings, LocalPool(workers))
            )
        )
        total = sum(counts[split] for split in ("train", "validation", "test"))
        rows.append({
            "workers": workers, "grids": total, "a_second": total / seconds,
            "bytes": _size(at) / total,
        })  # fmt: skip
    return {"rows": rows}


def training(folder: Path, given: argparse.Namespace) -> dict[str, Any]:
    """Training samples per second of `planes` from shards, with one process and with two."""
    shards = folder / "training"
    settings = TrainingSettings(**{**net_spec("planes").training, "net": "planes"})
    input_spec = net_spec("planes").input_spec
    assert isinstance(input_spec, GridSpec)
    conversion_settings = ConversionSettings(
        input_spec, settings.changes(input_spec.margin), 1, 512
    )
    convert(given.data, str(shards), conversion_settings, LocalPool(os.cpu_count() or 1))
    with ShardedSet.read(shards, "train") as sharded_set:
        batches = sharded_set.batches(BATCH, 0)
        seconds = _timed(lambda: [sharded_set.unpacked(rows) for rows in batches])
        read = sharded_set.steps(BATCH) * BATCH / seconds
    rows = []
    for processes in (1, 2):
        out = folder / f"run-{processes}"
        words = [
            sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node",
            str(processes), "-m", "circumspect", "train", "--data", str(shards), "--out", str(out),
            "--epochs", "2", "--batch-size", str(BATCH), "--precision", "bf16",
        ]  # fmt: skip
        threads = str(max(1, (os.cpu_count() or 1) // processes))
        environment = {**os.environ, "OMP_NUM_THREADS": threads}
        subprocess.run(words, check=True, env=environment, capture_output=True)
        # The first epoch includes one-time setup.
        _, last = (out / "epochs.csv").read_text().splitlines()[1:]
        named = dict(zip((out / "epochs.csv").read_text().split("\n")[0].split(","),
                         last.split(","), strict=True))  # fmt: skip
        samples = sharded_set.steps(BATCH, processes) * BATCH
        rows.append({
            "processes": processes, "a_second": samples / float(named["seconds"]),
            "loss": float(named["loss"]),
        })  # fmt: skip
    return {"read_a_second": read, "rows": rows}


def lost_node(folder: Path, given: argparse.Namespace) -> dict[str, Any]:
    """A Ray cluster of three nodes on loopback scans; one of them is killed."""
    del given
    from circumspect.gathering.ray_pool import RayPool

    at, objects = folder / "lost", objects_for(SCANS)
    with _cluster(3) as (cluster, nodes), RayPool.connected(cluster.address) as pool:

        def progress(done: int, _total: int, _key: str) -> None:
            if done == LOST_AFTER and nodes:
                cluster.remove_node(nodes.pop(), allow_graceful=False)

        name = pool.name
        seconds = _timed(lambda: gather(SetFolder(at), SCANS, objects, pool, progress=progress))
        left = pool.name
    lines = (at / "manifest.jsonl").read_text().splitlines()
    found = [json.loads(line)["scan"] for line in lines]
    return {
        "begun_with": name, "ended_with": left, "seconds": seconds, "asked": len(objects),
        "there": len(set(found)), "twice": len(found) - len(set(found)),
        "complete": verify_gathered(at).complete,
    }  # fmt: skip


@contextmanager
def _cluster(count: int) -> Iterator[tuple[Any, list[Any]]]:
    """Nodes of one core each; all but the head are listed."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    from ray.cluster_utils import Cluster

    quick = {"health_check_period_ms": 200, "health_check_failure_threshold": 3}
    head = {
        "num_cpus": 1, "include_dashboard": False, "object_store_memory": STORE,
        "_system_config": quick,
    }  # fmt: skip
    made = Cluster(initialize_head=True, head_node_args=head)
    try:
        nodes = [made.add_node(num_cpus=1, object_store_memory=STORE) for _ in range(count - 1)]
        yield made, nodes
    finally:
        made.shutdown()


def memory(folder: Path, given: argparse.Namespace) -> dict[str, Any]:
    """Peak memory of a process that streams an epoch of synthetic grids."""
    del given
    rows = []
    for size in SET_SIZES:
        at = folder / f"synthetic-{size}"
        _write_synthetic(at, size)
        words = [sys.executable, "-m", "benchmarks.scale", "--stream", str(at)]
        found = subprocess.run(words, check=True, capture_output=True, text=True)
        rows.append({"grids": size, **json.loads(found.stdout)})
        shutil.rmtree(at)
    return {"rows": rows}


def _write_synthetic(folder: Path, size: int) -> None:
    """Blocks of random bits, which compress about as well as grids of objects."""
    rng, store = np.random.default_rng(0), SetStore(folder)
    count = -(-size // SHARD)
    input_spec = GridSpec()
    for number in range(count):
        rows = min(SHARD, size - number * SHARD)
        blocks = rng.integers(0, 256, (rows, 128), np.uint8)
        packed = np.repeat(blocks, 32, axis=1)
        head = ShardHead(
            input_spec.to_dict(), (1, *input_spec.shape), ("a", "b"), {}, "train", number, count,
            __version__,
        )  # fmt: skip
        names = np.array([f"object-{number * SHARD + row}" for row in range(rows)])
        labels = rng.integers(0, 2, rows)
        write_shard(store, head, Rows(packed, labels, names, np.full(rows, np.nan)))


def stream(folder: Path) -> dict[str, float]:
    """Read an epoch as training does; memory [MB] at its start and at its peak."""
    base = high_water_mb(os.getpid())
    with ShardedSet.read(folder, "train") as shards:
        opened, count = high_water_mb(os.getpid()), 0
        start = time.perf_counter()
        for rows in shards.batches(BATCH, 0):
            count += len(shards.unpacked(rows))
        seconds = time.perf_counter() - start
    return {
        "base_mb": base, "opened_mb": opened, "peak_mb": high_water_mb(os.getpid()),
        "a_second": count / seconds,
        "read": count,
    }  # fmt: skip


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


PARTS = {
    "scans": scans, "conversion": conversion, "training": training, "lost_node": lost_node,
    "memory": memory,
}  # fmt: skip


def _text(found: dict[str, Any]) -> str:
    scan, made, learnt = (found[part] for part in ("scans", "conversion", "training"))
    lost, streamed = found["lost_node"], found["memory"]
    ratio = [scan["rows"][0]["seconds"] / row["seconds"] for row in scan["rows"]]
    of_grids = [row["a_second"] / made["rows"][0]["a_second"] for row in made["rows"]]
    workers = [
        [str(row["workers"]), f"{row['seconds']:.1f}", f"{one:.2f}", f"{other['a_second']:.0f}",
         f"{two:.2f}"]
        for row, one, other, two in zip(scan["rows"], ratio, made["rows"], of_grids, strict=True)
    ]  # fmt: skip
    first = scan["rows"][0]
    processes = [
        [str(row["processes"]), f"{row['a_second']:.0f}", f"{row['loss']:.3f}"]
        for row in learnt["rows"]
    ]
    sizes = [
        [f"{row['grids']:,}", f"{row['base_mb']:.0f}", f"{row['opened_mb']:.0f}",
         f"{row['peak_mb']:.0f}", f"{row['a_second']:,.0f}"]
        for row in streamed["rows"]
    ]  # fmt: skip
    head = ["workers", "seconds a scan", "speed-up", "grids converted a second", "speed-up"]
    return (
        f"A scan of furniture has {first['frames']:.0f} frames at one every "
        f"{SCANS.frame_interval:g} s, takes {first['processor_s']:.1f} s of one core, and writes "
        f"{first['bytes'] / 1e6:.2f} MB. A converted grid takes "
        f"{made['rows'][0]['bytes']:.0f} bytes.\n\n{table(head, workers)}\n\n"
        f"From shards a process reads {learnt['read_a_second']:,.0f} grids a second; `planes` is "
        f"trained in bf16 with batches of {BATCH}:\n\n"
        + table(["processes", "samples a second", "loss of the second epoch"], processes)
        + f"\n\nA Ray cluster on this machine ({lost['begun_with']}) lost a node after "
        f"{LOST_AFTER} scans and ended with {lost['ended_with']}: {lost['there']} of "
        f"{lost['asked']} scans exist, {lost['twice']} twice, and `data verify` finds the set "
        f"{'complete' if lost['complete'] else 'incomplete'}.\n\n"
        "Memory of a process that streams an epoch of synthetic grids:\n\n"
        + table(["grids", "before [MB]", "shards open [MB]", "peak [MB]", "grids a second"], sizes)
    )


def main() -> int:
    """Measure the parts, and write the page when all parts have results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--part", choices=PARTS)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--stream", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.stream is not None:
        print(json.dumps(stream(given.stream)))
        return 0
    path = given.out / "scale.json"
    found = json.loads(path.read_text()) if path.exists() else {}
    for part in [given.part] if given.part else PARTS:
        with tempfile.TemporaryDirectory() as folder:
            found[part] = PARTS[part](Path(folder), given)
        write_json(path, found)
    if set(PARTS) <= set(found):
        measured = {part: found[part] for part in PARTS}
        command = "python -m benchmarks.scale"
        write_page("scale", "Beyond one process", command, _text(measured), measured, given.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
