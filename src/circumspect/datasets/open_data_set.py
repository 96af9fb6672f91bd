"""Opening of data sets by path."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from circumspect.datasets.gathered_set import (
    is_gathered,
    read_gathered,
    read_training,
)
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.off_folder import object_files, read_off_folder
from circumspect.datasets.point_pack import read_point_pack
from circumspect.datasets.validation_split import validation_split
from circumspect.errors import InputError

Split = Literal["train", "fit", "validation", "test"]


def open_data_set(
    path: Path, split: Split, progress: Callable[[int, int], None] | None = None, salt: str = ""
) -> ObjectSet:
    """Read one split of a data set.

    Args:
        path: A folder of point packs (`train.npz`, `test.npz`); a folder of object files of any
            readable format, `<class>/{train,test}/*`, such as ModelNet10; a gathered set, whose
            scans from the first start of each object train and all test; or one point pack, which
            is then the whole split.
        split: "train" is the official training split; "fit" and "validation" are its two
            parts; "test" is for reports only.
        progress: Called with (done, all) while objects are sampled.
        salt: Salt of the validation split.

    Raises:
        InputError: There is no data set, a file is broken, or two objects of a pack share a name.
    """
    source = "test" if split == "test" else "train"
    if path.is_file() and split in ("fit", "validation"):
        raise InputError(f"{path}: a lone pack is not split; give its folder")
    objects = _read(path, source, progress)
    if split in ("train", "test"):
        return objects
    held_back = validation_split(objects, salt)
    return objects.subset(held_back if split == "validation" else ~held_back)


def _read(path: Path, source: str, progress: Callable[[int, int], None] | None) -> ObjectSet:
    if path.is_file():
        return _lone_pack(path, source)
    if (path / f"{source}.npz").is_file():
        return _pack(path / f"{source}.npz")
    if is_gathered(path):
        return _gathered(path, source)
    if path.is_dir():
        _require_meshes_or_packs(path, source)
        return read_off_folder(path, source, progress)
    raise InputError(f"{path}: no such folder or file; give point packs or the OFF folder")


def _require_meshes_or_packs(path: Path, source: str) -> None:
    """Refuse a folder that has only the pack of the other split."""
    other = "train" if source == "test" else "test"
    if (path / f"{other}.npz").is_file() and not object_files(path, source):
        raise InputError(
            f"{path}: {source}.npz is missing, only {other}.npz is there; the {source} split needs "
            "a pack of its own"
        )


def _gathered(path: Path, source: str) -> ObjectSet:
    if source == "test":
        return read_gathered(path, "test")
    return read_training(path)


def _lone_pack(path: Path, source: str) -> ObjectSet:
    if source == "test" and path.stem == "train":
        raise InputError(
            f"{path}: the training split is no test of anything; give a folder that holds test.npz "
            "as well (evaluate takes --split train)"
        )
    if source == "train" and path.stem == "test":
        raise InputError(f"{path}: the test split is for reports, not for training or choosing")
    return _pack(path)


def _pack(path: Path) -> ObjectSet:
    """Read a pack; its names must be unique, since they identify the training objects."""
    objects = read_point_pack(path)
    counts = Counter(objects.names.tolist())
    if twice := sorted(name for name, count in counts.items() if count > 1):
        raise InputError(
            f"{path}: {len(twice)} names stand for more than one object, as {twice[0]} does; name "
            "each object otherwise, such as CLASS/NAME"
        )
    return objects
