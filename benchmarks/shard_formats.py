"""Formats for sets of grids that are larger than memory: Parquet, WebDataset, Zarr.

    pip install pyarrow webdataset==1.0.2 zarr==3.1.6
    python -m benchmarks.shard_formats --data ../shared/data/modelnet10

Grids of ModelNet10's training objects, each turned by whole cells so that no two are equal, are
written in shards with label, object and start. An epoch reads every grid once, shuffled by shards
and within a buffer, in batches. `docs/development/shard-formats.md` discusses the results.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import write_page
from benchmarks.scans import DATA
from circumspect.classification import GridSpec
from circumspect.datasets.point_pack import read_point_pack
from circumspect.evaluation.markdown import table

SHARD, GROUP, BATCH = 4096, 512, 64
"""Grids in a shard, in what is read at a time, and in a batch."""
BUFFER = 8
"""Groups among which an epoch is shuffled."""
BITS = 32**3


class Format(ABC):
    """Writes and reads a set of packed grids."""

    name: str
    package: str

    @abstractmethod
    def write(self, folder: Path, grids: NDArray[np.uint8], labels: NDArray[np.int64]) -> None:
        """Write (n, bytes) grids."""

    @abstractmethod
    def epoch(self, folder: Path, seed: int, start: int = 0) -> Iterator[NDArray[np.uint8]]:
        """Batches of an epoch from sample `start` on, shuffled by a seed."""

    @abstractmethod
    def largest(self, folder: Path) -> Path:
        """The file with most of the data."""


class Parquet(Format):
    """Apache Parquet by pyarrow: one file a shard."""

    name, package = "Parquet", "pyarrow"

    def write(self, folder: Path, grids: NDArray[np.uint8], labels: NDArray[np.int64]) -> None:
        import pyarrow as pa
        from pyarrow import parquet

        shards, width = list(_shards(len(grids))), grids.shape[1]
        for number, rows in enumerate(shards):
            blob = pa.FixedSizeBinaryArray.from_buffers(
                pa.binary(width), len(rows), [None, pa.py_buffer(grids[rows].tobytes())]
            )
            columns = {
                "grid": blob, "label": labels[rows], "object": [f"object-{n}" for n in rows],
                "start_deg": np.zeros(len(rows)),
            }  # fmt: skip
            whole = pa.table(columns).replace_schema_metadata({"shape": json.dumps([32, 32, 32])})
            path = folder / f"{number:05}-of-{len(shards):05}.parquet"
            parquet.write_table(
                whole, path, row_group_size=GROUP, compression="zstd", write_page_checksum=True
            )

    def epoch(self, folder: Path, seed: int, start: int = 0) -> Iterator[NDArray[np.uint8]]:
        from pyarrow import parquet

        paths = sorted(folder.glob("*.parquet"))
        if len(paths) < int(paths[0].stem.partition("-of-")[2]):
            raise FileNotFoundError("a shard")
        files = [parquet.ParquetFile(path, page_checksum_verification=True) for path in paths]
        sizes = [
            (file, group, file.metadata.row_group(group).num_rows)
            for file in files
            for group in range(file.metadata.num_row_groups)
        ]

        def rows(number: int) -> NDArray[np.uint8]:
            file, group, _ = sizes[number]
            return _unpacked(file.read_row_group(group, columns=["grid", "label"])["grid"])

        yield from _shuffled(rows, [count for *_, count in sizes], seed, start)

    def largest(self, folder: Path) -> Path:
        return min(folder.glob("*.parquet"))


def _unpacked(column: Any) -> NDArray[np.uint8]:
    whole = column.combine_chunks()
    buffer = np.frombuffer(whole.buffers()[1], np.uint8)
    width = whole.type.byte_width
    return buffer[whole.offset * width :][: len(whole) * width].reshape(len(whole), width)


class Zarr(Format):
    """Zarr 3: arrays of one group, in shards of chunks."""

    name, package = "Zarr", "zarr"

    def write(self, folder: Path, grids: NDArray[np.uint8], labels: NDArray[np.int64]) -> None:
        import zarr  # pyright: ignore[reportMissingImports]

        group = zarr.open_group(folder, mode="w", attributes={"shape": [32, 32, 32]})
        width = grids.shape[1]
        group.create_array("grid", data=grids, chunks=(GROUP, width), shards=(SHARD, width))
        group.create_array("label", data=labels, chunks=(GROUP,), shards=(SHARD,))
        group.create_array("object", data=np.arange(len(grids)), chunks=(GROUP,), shards=(SHARD,))
        group.create_array("start_deg", data=np.zeros(len(grids)), chunks=(GROUP,), shards=(SHARD,))

    def epoch(self, folder: Path, seed: int, start: int = 0) -> Iterator[NDArray[np.uint8]]:
        import zarr  # pyright: ignore[reportMissingImports]

        group: Any = zarr.open_group(folder, mode="r")
        grids, labels = group["grid"], group["label"]
        firsts = range(0, grids.shape[0], GROUP)

        def rows(number: int) -> NDArray[np.uint8]:
            chosen = slice(firsts[number], firsts[number] + GROUP)
            _ = labels[chosen]
            return grids[chosen]

        counts = [min(GROUP, grids.shape[0] - first) for first in firsts]
        yield from _shuffled(rows, counts, seed, start)

    def largest(self, folder: Path) -> Path:
        return max((file for file in folder.rglob("*") if file.is_file()), key=_size)


class WebDataset(Format):
    """WebDataset: one tar a shard, two members a grid."""

    name, package = "WebDataset", "webdataset"

    def write(self, folder: Path, grids: NDArray[np.uint8], labels: NDArray[np.int64]) -> None:
        from webdataset.writer import TarWriter  # pyright: ignore[reportMissingImports]

        for number, rows in enumerate(_shards(len(grids))):
            with TarWriter(str(folder / f"{number:05}.tar")) as sink:
                for row in rows:
                    fields = {
                        "label": int(labels[row]),
                        "object": f"object-{row}",
                        "start_deg": 0.0,
                    }
                    sink.write({
                        "__key__": f"{row:08}", "grid": grids[row].tobytes(), "json": fields,
                    })  # fmt: skip

    def epoch(self, folder: Path, seed: int, start: int = 0) -> Iterator[NDArray[np.uint8]]:
        from webdataset.compat import WebDataset as Samples  # pyright: ignore[reportMissingImports]

        paths = [str(path) for path in sorted(folder.glob("*.tar"))]
        source = Samples(paths, shardshuffle=len(paths), detshuffle=True, seed=seed)
        samples: Any = source.shuffle(BUFFER * GROUP, seed=seed)
        waiting: list[NDArray[np.uint8]] = []
        for number, sample in enumerate(samples):
            # A later sample is reached only by reading all samples before it.
            if number < start:
                continue
            json.loads(sample["json"])
            waiting.append(np.frombuffer(sample["grid"], np.uint8))
            if len(waiting) == BATCH:
                yield np.stack(waiting)
                waiting = []
        if waiting:
            yield np.stack(waiting)

    def largest(self, folder: Path) -> Path:
        return min(folder.glob("*.tar"))


FORMATS = (Parquet(), WebDataset(), Zarr())


def _shards(count: int) -> Iterator[range]:
    for first in range(0, count, SHARD):
        yield range(first, min(first + SHARD, count))


def _size(path: Path) -> int:
    return path.stat().st_size


def _shuffled(rows: Any, counts: list[int], seed: int, start: int) -> Iterator[NDArray[np.uint8]]:
    """Groups in random order; the grids of `BUFFER` groups are shuffled together."""
    rng = np.random.default_rng(seed)
    order, skipped, left = rng.permutation(len(counts)), start, None
    for first in range(0, len(order), BUFFER):
        some = order[first : first + BUFFER]
        count = sum(counts[group] for group in some)
        within = rng.permutation(count)
        if skipped >= count:  # None of these groups is read.
            skipped -= count
            continue
        held = np.concatenate([rows(int(group)) for group in some])[within[skipped:]]
        held, skipped = held if left is None else np.concatenate([left, held]), 0
        whole = len(held) // BATCH * BATCH
        for at in range(0, whole, BATCH):
            yield held[at : at + BATCH]
        left = held[whole:]
    if left is not None and len(left):
        yield left


def grids_of(data: Path, count: int) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Packed grids of real objects, no two of them equal, and their labels."""
    objects = read_point_pack(data / "train.npz")
    input_spec, turns = GridSpec(azimuth_views=1), 32
    chosen = np.linspace(0, len(objects) - 1, -(-count // turns)).astype(int)
    packed, labels = [], []
    for index in chosen.tolist():
        grid = input_spec.grids(objects.cloud(index), [0.0])[0, 0]
        for turn in range(turns):
            packed.append(np.packbits(np.roll(grid, turn, axis=1).reshape(-1)))
            labels.append(int(objects.labels[index]))
    shuffled = np.random.default_rng(0).permutation(len(packed))[:count]
    return np.stack(packed)[shuffled], np.array(labels)[shuffled]


def measured(kind: Format, folder: Path, grids: NDArray[np.uint8], labels: Any) -> dict[str, Any]:
    """Cost of a format, and its reaction to damaged files."""
    began = time.perf_counter()
    kind.write(folder, grids, labels)
    wrote = time.perf_counter() - began
    size = sum(_size(file) for file in folder.rglob("*") if file.is_file())
    began, seen = time.perf_counter(), 0
    for batch in kind.epoch(folder, 1):
        seen += len(batch)
    epoch = time.perf_counter() - began
    assert seen == len(grids), f"{kind.name}: {seen} of {len(grids)}"
    began = time.perf_counter()
    next(iter(kind.epoch(folder, 1, int(0.9 * len(grids)))))
    resumed = time.perf_counter() - began
    return {
        "format": f"{kind.name} ({kind.package} {version(kind.package)})",
        "bytes": size / len(grids),
        "written": len(grids) / wrote,
        "read": len(grids) / epoch,
        "resumed_s": resumed,
        "truncated": _outcome(kind, folder, grids, _truncate),
        "flipped": _outcome(kind, folder, grids, _flip),
        "lost": _outcome(kind, folder, grids, Path.unlink),
    }


def _truncate(path: Path) -> None:
    os.truncate(path, _size(path) // 2)


def _flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def _outcome(kind: Format, folder: Path, grids: NDArray[np.uint8], damage: Any) -> str:
    """Outcome of an epoch over a damaged set."""
    with tempfile.TemporaryDirectory() as parent:
        copy = Path(shutil.copytree(folder, Path(parent) / "set"))
        damage(kind.largest(copy))
        try:
            read = np.concatenate(list(kind.epoch(copy, 1)))
        except Exception as error:
            return f"{type(error).__name__}"
    if len(read) < len(grids):
        return f"silent: {len(grids) - len(read)} grids lost"
    originals = {row.tobytes() for row in grids}
    wrong = sum(row.tobytes() not in originals for row in read)
    return f"silent: {wrong} grids wrong" if wrong else "no harm"


def main() -> int:
    """Measure all formats and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--grids", type=int, default=40_000)
    given = parser.parse_args()
    grids, labels = grids_of(given.data, given.grids)
    rows = []
    for kind in FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(measured(kind, Path(folder), grids, labels))
    head = [
        "format", "bytes a grid", "written a second", "read a second", "resume at 90 % [s]",
        "truncated shard", "flipped bit", "lost shard",
    ]  # fmt: skip
    lines = [
        [row["format"], f"{row['bytes']:.0f}", f"{row['written']:,.0f}", f"{row['read']:,.0f}",
         f"{row['resumed_s']:.2f}", row["truncated"], row["flipped"], row["lost"]]
        for row in rows
    ]  # fmt: skip
    text = (
        f"{len(grids):,} grids of 32 x 32 x 32 bits, {grids.shape[1]} bytes each, in shards of "
        f"{SHARD:,}; an epoch is shuffled by groups of {GROUP} and among {BUFFER} groups at a "
        f"time.\n\n{table(head, lines)}"
    )
    command = "python -m benchmarks.shard_formats"
    write_page("shard_formats", "Formats of shards", command, text, {"rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
