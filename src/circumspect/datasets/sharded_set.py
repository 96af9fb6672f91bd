"""Sharded sets of grids, read as a shuffled, resumable stream in bounded memory."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.set_store import SetStore
from circumspect.datasets.shard_file import Rows, ShardFile, ShardHead
from circumspect.errors import InputError

BUFFER = 8
"""Number of row groups in the shuffle buffer."""


class ShardedSet:
    """One split of a set.

    Attributes:
        head: Head of the first shard, which all shards share except number and counts.
    """

    def __init__(self, shards: list[ShardFile]) -> None:
        """Set the open shards; see `read`."""
        self._shards = shards
        self.head: ShardHead = shards[0].head
        self._groups = [(shard, n) for shard in shards for n in range(len(shard.groups))]
        self._sizes = np.array([size for shard in shards for size in shard.groups], np.int64)

    @classmethod
    def read(cls, url: str | os.PathLike[str], split: str) -> Self:
        """Open all shards of a split without reading their grids.

        Args:
            url: The set, a folder or a URL.
            split: "train", "validation" or "test".

        Raises:
            InputError: A shard is missing, broken, or does not match the others; the message names
                it.
            MissingExtraError: pyarrow or fsspec is not installed.
        """
        store = SetStore(url)
        names = store.names(f"{split}/*.parquet")
        _require_all(store, split, names)
        with ExitStack() as opened:
            shards = []
            for name in names:
                shards.append(ShardFile(store, name))
                opened.callback(shards[-1].close)
            for shard in shards[1:]:
                _require_same(shards[0], shard)
            opened.pop_all()
            return cls(shards)

    def __len__(self) -> int:
        return int(self._sizes.sum())

    @property
    def names(self) -> list[str]:
        """Names of the shards inside the set."""
        return [shard.head.name for shard in self._shards]

    @property
    def groups(self) -> int:
        """Number of row groups of all shards, which processes share."""
        return len(self._groups)

    @property
    def classes(self) -> tuple[str, ...]:
        """Class names in the order of the labels."""
        return self.head.classes

    def in_order(self) -> Iterator[Rows]:
        """All grids, a row group at a time.

        Raises:
            InputError: A shard is broken.
        """
        for shard, group in self._groups:
            yield shard.rows(group)

    def steps(self, batch: int, world: int = 1) -> int:
        """Number of whole batches in an epoch.

        Args:
            batch: Grids in a batch, over all processes.
            world: Number of processes that share an epoch.
        """
        # A lower bound for any order: all processes take equally many steps in every epoch.
        fewest = np.sort(self._sizes)[: len(self._sizes) // world].sum()
        return int(fewest) // (batch // world)

    def batches(
        self, batch: int, seed: int, first: int = 0, rank: int = 0, world: int = 1
    ) -> Iterator[Rows]:
        """An epoch of whole batches.

        Row groups are shuffled and distributed to the processes. Each process shuffles grids among
        `BUFFER` of its groups, which bounds its memory. Groups before batch `first` are not read.

        Args:
            batch: Grids in a batch, over all processes; a multiple of `world`.
            seed: Seed of the order; the same for all processes, another one for each epoch.
            first: Number of the first batch.
            rank: Number of this process.
            world: Number of processes.

        Yields:
            This process' part of each batch.

        Raises:
            InputError: A shard is broken.
        """
        share, left = batch // world, None
        skipped = first * share
        remaining = self.steps(batch, world) - first
        for held in self._shuffled(seed, rank, world, skipped):
            rows = held if left is None else Rows.joined([left, held])
            whole = min(len(rows) // share, remaining)
            for number in range(whole):
                yield rows.subset(slice(number * share, (number + 1) * share))
            remaining -= whole
            if remaining <= 0:
                return
            left = rows.subset(slice(whole * share, None))

    def _shuffled(self, seed: int, rank: int, world: int, skipped: int) -> Iterator[Rows]:
        """The grids of a process in the order of an epoch, one buffer at a time."""
        rng = np.random.default_rng([seed, rank])
        mine = self._order(seed)[rank::world]
        for start in range(0, len(mine), BUFFER):
            groups = mine[start : start + BUFFER]
            count = int(self._sizes[groups].sum())
            within = rng.permutation(count)
            if skipped >= count:
                skipped -= count
                continue
            read = [self._groups[number] for number in groups]
            yield Rows.joined([shard.rows(n) for shard, n in read]).subset(within[skipped:])
            skipped = 0

    def _order(self, seed: int) -> NDArray[np.int64]:
        """Row groups of an epoch, before they are distributed."""
        return np.random.default_rng(seed).permutation(len(self._groups))

    def unpacked(self, rows: Rows) -> NDArray[np.uint8]:
        """(n, views, *cells) grids, 1 where occupied."""
        shape = self.head.shape
        bits = np.unpackbits(rows.packed, axis=1, count=int(np.prod(shape)))
        return bits.reshape(len(rows), *shape)

    def counts(self) -> dict[str, int]:
        """Number of grids per class, from the heads of the shards."""
        total = np.sum([shard.head.counts for shard in self._shards], axis=0)
        return dict(zip(self.classes, total.tolist(), strict=True))

    def close(self) -> None:
        """Close all files."""
        for shard in self._shards:
            shard.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def is_sharded(url: str) -> bool:
    """Whether a path or URL is read as shards; all URLs are."""
    return "://" in url or any(Path(url).glob("*/*.parquet"))


def _require_all(store: SetStore, split: str, names: list[str]) -> None:
    if not names:
        raise InputError(f"{store.url}: holds no shard of the {split} split")
    counts = {match[1] for name in names if (match := re.search(r"-of-(\d+)\.parquet$", name))}
    if len(counts) != 1:
        raise InputError(f"{store.url}: holds shards of several sets in its {split} split")
    count = int(counts.pop())
    wanted = {f"{split}/{number:05}-of-{count:05}.parquet" for number in range(count)}
    if lacking := sorted(wanted - set(names)):
        raise InputError(
            f"{store.place(lacking[0])}: is missing, with {len(lacking) - 1} more; convert the set "
            "again, which makes what is missing"
        )


def _require_same(first: ShardFile, other: ShardFile) -> None:
    for what in ("input_spec", "shape", "classes", "source", "split"):
        one, two = getattr(first.head, what), getattr(other.head, what)
        if one != two:
            raise InputError(
                f"{other.place}: differs in {what} from {first.place} ({_short(two)}, not "
                f"{_short(one)})"
            )


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}…"
