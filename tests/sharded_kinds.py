"""Objects of two kinds in shards."""

from __future__ import annotations

from pathlib import Path

from here_pool import HerePool
from two_kinds import renamed, two_kinds

from circumspect.classification import GridSpec
from circumspect.datasets import Augmentation
from circumspect.datasets.point_pack import write_point_pack
from circumspect.gathering.conversion import ConversionSettings, convert

SETTINGS = ConversionSettings(
    GridSpec(azimuth_views=2, shape=(16, 16, 16)), Augmentation(), replicas=4, shard_size=32
)


def sharded_kinds(folder: Path, count: int = 96, settings: ConversionSettings = SETTINGS) -> Path:
    """Convert `count` training objects, some held back for validation, and 10 test objects."""
    packs, shards = folder / "packs", folder / "shards"
    packs.mkdir(parents=True)
    tests = renamed(two_kinds(10, seed=3), "test")
    for split, objects in (("train", two_kinds(count, seed=1)), ("test", tests)):
        write_point_pack(packs / f"{split}.npz", objects)
    convert(packs, str(shards), settings, HerePool())
    return shards
