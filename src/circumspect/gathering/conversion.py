"""Convert a labelled set to shards of grids: variants for training, plain views for tests."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect import __version__
from circumspect.classification import GridSpec
from circumspect.datasets import ObjectSet, open_data_set
from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.augmented_clouds import AugmentedClouds
from circumspect.datasets.gathered_set import is_gathered, read_manifest
from circumspect.datasets.set_store import SetStore
from circumspect.datasets.shard_file import Rows, ShardFile, ShardHead, require_pyarrow, write_shard
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.datasets.validation_split import validation_split
from circumspect.errors import GeometryError, InputError, OutputError
from circumspect.gathering.job_pool import JobPool
from circumspect.grid import hits_batch


@dataclass(frozen=True)
class ConversionSettings:
    """Settings of a conversion.

    Attributes:
        input_spec: Specification of the grids.
        augmentation: Random changes of the training objects.
        replicas: Variants of each training object.
        shard_size: Rows of a shard.
        seed: Of the variants, and of the order of objects.
    """

    input_spec: GridSpec
    augmentation: Augmentation
    replicas: int = 1
    shard_size: int = 4096
    seed: int = 0

    def __post_init__(self) -> None:
        if self.input_spec.visibility or self.input_spec.metric:
            raise InputError("shards hold grids of occupancy; take a network that is shown no more")
        if self.replicas < 1 or self.shard_size < self.replicas:
            raise InputError(
                f"{self.replicas} variants in shards of {self.shard_size}: a shard holds all "
                "variants of an object at least"
            )


@dataclass(frozen=True, eq=False)
class ConversionJob:
    """A shard to make.

    Attributes:
        head: Of the shard.
        objects: Those of the shard.
        starts_deg: Name of a scan to the azimuth of its start [degrees], if known.
        settings: Of the set.
        url: Of the shards.
    """

    head: ShardHead
    objects: ObjectSet
    starts_deg: Mapping[str, float]
    settings: ConversionSettings
    url: str

    @property
    def key(self) -> str:
        """The shard's name."""
        return self.head.name


def convert(
    source: Path,
    url: str,
    settings: ConversionSettings,
    pool: JobPool,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, int]:
    """Make the missing shards.

    Args:
        source: A set as `open_data_set` reads it; a part of its training split becomes validation.
        url: Of the shards, a folder or a URL; all nodes of a cluster must see it.
        settings: Settings of the conversion.
        pool: Runs the jobs.
        progress: Called with (done, all) before the first shard and after each.

    Returns:
        Split to its rows, and "left out" to objects that span no shape.

    Raises:
        InputError: The set is broken, an object is in two splits, or the place holds other shards.
        OutputError: A shard cannot be written.
        MissingExtraError: pyarrow or fsspec is not installed.
    """
    require_pyarrow()
    store = SetStore(url)
    objects, starts = _objects_of(source), _starts_of(source)
    _require_apart(objects)
    heads = {split: _heads(split, one, settings) for split, one in objects.items()}
    there = _whole_shards(store, heads)
    total = sum(len(some) for some in heads.values())
    if progress is not None:
        progress(len(there), total)
    done, failed = len(there), list[str]()
    jobs = (
        ConversionJob(head, objects[split].subset(members), starts, settings, url)
        for split, some in heads.items()
        for head, members in some
        if head.name not in there
    )
    for job, outcome in pool.outcomes(jobs, converted):
        done += 1
        if isinstance(outcome, InputError):
            raise outcome
        if isinstance(outcome, BaseException):
            failed.append(f"{job.key} ({outcome})")
        if progress is not None:
            progress(done, total)
    if failed:
        raise OutputError(
            f"{url}: {len(failed)} shards failed, the first: {failed[0]}; the same command tries "
            "them again"
        )
    return _counts(url, objects, settings)


def converted(job: ConversionJob) -> dict[str, Any]:
    """Make a shard.

    Raises:
        OutputError: It cannot be written.
    """
    made = list(_variants(job) if job.head.split == "train" else _views(job))
    packed = [np.packbits(grids.reshape(-1)) for _, grids in made]
    members = np.array([index for index, _ in made], np.int64)
    objects = job.objects
    rows = Rows(
        np.array(packed, np.uint8).reshape(len(made), job.head.grid_bytes),
        objects.labels[members], objects.shown[members],
        np.array([job.starts_deg.get(name, np.nan) for name in objects.names[members].tolist()]),
    )  # fmt: skip
    if job.head.split == "train":
        # Shuffle variants, so that a row group holds many objects.
        order = np.random.default_rng([job.settings.seed, job.head.number]).permutation(len(rows))
        rows = rows.subset(order)
    write_shard(SetStore(job.url), job.head, rows)
    return {"key": job.key, "rows": len(rows)}


def _objects_of(source: Path) -> dict[str, ObjectSet]:
    """Split to its objects; a part of the training split becomes validation."""
    train, test = open_data_set(source, "train"), open_data_set(source, "test")
    held_back = validation_split(train)
    return {"train": train.subset(~held_back), "validation": train.subset(held_back), "test": test}


def _starts_of(source: Path) -> dict[str, float]:
    """Scan to the azimuth of its start [degrees], of gathered sets."""
    scans = read_manifest(source) if is_gathered(source) else []
    return {scan.scan: scan.start_deg for scan in scans if scan.start_deg is not None}


def _variants(job: ConversionJob) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    """Index and grid (1, *cells) of each variant."""
    settings = job.settings
    # Each shard has its own seed: variants are identified by the object's index in its shard.
    seed = settings.seed * 1_000_003 + job.head.number
    clouds = AugmentedClouds(job.objects, settings.augmentation, seed)
    for index in range(len(job.objects)):
        samples = [clouds.samples(index, replica) for replica in range(settings.replicas)]
        bounds = [settings.input_spec.unit_bounds] * len(samples)
        for grid in hits_batch(bounds, samples, threads=1):
            yield index, grid[None]


def _views(job: ConversionJob) -> Iterator[tuple[int, NDArray[np.uint8]]]:
    """Index and grids (views, *cells) of each object that spans a shape."""
    for index in range(len(job.objects)):
        try:
            yield index, job.settings.input_spec.grids(job.objects.cloud(index), [0.0])[0]
        except GeometryError:
            continue


def _heads(
    split: str, objects: ObjectSet, settings: ConversionSettings
) -> list[tuple[ShardHead, NDArray[np.int64]]]:
    """The shards of a split, each with the objects that it holds, in random order."""
    order = np.random.default_rng(settings.seed).permutation(len(objects))
    each = settings.shard_size // (settings.replicas if split == "train" else 1)
    parts = [order[first : first + each] for first in range(0, len(order), each)]
    views = 1 if split == "train" else settings.input_spec.azimuth_views
    source: dict[str, Any] = {"objects": objects.digest, "seed": settings.seed}
    if split == "train":
        changes = json.loads(json.dumps(asdict(settings.augmentation)))
        source |= {"replicas": settings.replicas, "augmentation": changes}
    head = ShardHead(
        settings.input_spec.to_dict(), (views, *settings.input_spec.shape), objects.classes,
        source, split, 0, len(parts), __version__,
    )  # fmt: skip
    return [(replace(head, number=number), part) for number, part in enumerate(parts)]


def _require_apart(objects: dict[str, ObjectSet]) -> None:
    splits = list(objects.items())
    for number, (split, some) in enumerate(splits):
        for other, others in splits[:number]:
            if both := sorted(set(some.shown.tolist()) & set(others.shown.tolist())):
                raise InputError(f"{both[0]} is in the {other} and in the {split} split")


def _whole_shards(
    store: SetStore, heads: Mapping[str, Sequence[tuple[ShardHead, NDArray[np.int64]]]]
) -> set[str]:
    """Names of complete shards.

    Raises:
        InputError: The place holds other shards.
    """
    wanted = {head.name: head for some in heads.values() for head, _ in some}
    found = set[str]()
    for name in [name for split in heads for name in store.names(f"{split}/*.parquet")]:
        if name not in wanted:
            raise InputError(f"{store.place(name)}: is of another set; take another place")
        try:
            shard = ShardFile(store, name)
        except InputError:
            continue  # It is made again.
        head = shard.head
        shard.close()
        if replace(head, counts=()) != wanted[name]:
            raise InputError(f"{store.place(name)}: is of another set; take another place")
        found.add(name)
    return found


def _counts(
    url: str, objects: Mapping[str, ObjectSet], settings: ConversionSettings
) -> dict[str, int]:
    counts = {}
    for split in objects:
        with ShardedSet.read(url, split) as shards:
            counts[split] = len(shards)
    asked = sum(
        len(one) * (settings.replicas if split == "train" else 1) for split, one in objects.items()
    )
    return {**counts, "left out": asked - sum(counts.values())}
