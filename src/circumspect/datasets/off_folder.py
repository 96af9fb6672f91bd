"""Folders of object files, `<class>/{train,test}/*`: ModelNet10 or own classes."""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import numpy as np

from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.farthest_points import CANDIDATES, POINTS
from circumspect.datasets.object_mesh import is_object_file, sample_object
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.point_pack import read_point_pack, write_point_pack
from circumspect.datasets.verification import MODELNET10, NAME
from circumspect.errors import InputError, printable

VERSION = 3
log = logging.getLogger(__name__)


def read_off_folder(
    folder: Path, split: str, progress: Callable[[int, int], None] | None = None
) -> ObjectSet:
    """Sample every object of one split; the result is cached as a point pack.

    Files may have any readable format. Sizes are in metres if the format specifies the unit.

    A set that looks like a copy of ModelNet10 but contains files with foreign names is read with a
    warning.

    Args:
        folder: Folder with one folder per class.
        split: "train" or "test".
        progress: Called with (done, all) after each file.

    Raises:
        InputError: The split does not exist, two files have the same name, or a file cannot be
            read.
    """
    files = object_files(folder, split)
    if not files:
        raise InputError(
            f"{folder}: no <class>/{split}/*.off below it, nor files of another readable format"
        )
    _warn_of_foreign_names(folder, split, files)
    cached = cache_folder("packs") / f"{_fingerprint(files)}.npz"
    with suppress(InputError):
        return read_point_pack(cached)
    objects = _sample(files, progress)
    write_point_pack(cached, objects)
    log.info("%s: %d objects sampled, kept as %s", folder, len(objects), cached)
    # Quantised like every later read, so that their results agree.
    return read_point_pack(cached)


def object_files(folder: Path, split: str) -> list[Path]:
    """The object files of one split, in order.

    Raises:
        InputError: Two files differ only in their suffix, and would be the same object.
    """
    files = sorted(file for file in folder.glob(f"*/{split}/*") if is_object_file(file))
    named: dict[Path, Path] = {}
    for file in files:
        other = named.setdefault(file.with_suffix(""), file)
        if other is not file:
            raise InputError(f"{other} and {file}: one object in two files; remove one of them")
    return files


def _warn_of_foreign_names(folder: Path, split: str, files: list[Path]) -> None:
    """Warn of files that are not named after their class folder.

    Folders of other classes may have files of any name.
    """
    if {file.parent.parent.name for file in files} != set(MODELNET10):
        return
    foreign = [file for file in files if not _is_named_after_its_class(file)]
    if foreign:
        log.warning(
            "%s: %d of %d %s files bear names foreign to their class folder, such as %s; "
            "circumspect data verify %s names them",
            printable(str(folder)), len(foreign), len(files), split,
            printable(str(foreign[0].relative_to(folder))), printable(str(folder)),
        )  # fmt: skip


def _is_named_after_its_class(file: Path) -> bool:
    named = NAME.fullmatch(file.stem)
    return named is not None and named[1] == file.parent.parent.name


def _sample(files: list[Path], progress: Callable[[int, int], None] | None) -> ObjectSet:
    classes = tuple(sorted({file.parent.parent.name for file in files}))
    points, sides = np.empty((len(files), POINTS, 3), np.float32), np.empty(len(files))
    metric = np.zeros(len(files), bool)
    with ThreadPoolExecutor() as pool:
        for index, sample in enumerate(pool.map(sample_object, files)):
            points[index], sides[index], metric[index] = (
                sample.points_xyz,
                sample.side,
                sample.metric,
            )
            if progress:
                progress(index + 1, len(files))
    labels = np.array([classes.index(file.parent.parent.name) for file in files], np.int64)
    names = np.array([object_name(file) for file in files])
    known = metric if metric.any() else None
    return ObjectSet(points, labels, names, classes, sides=sides, metric=known)


def object_name(file: Path) -> str:
    """The name of the object in a file, unique among classes and splits.

    chair/train/chair_0001.off is chair_0001; chair/train/0001.off is chair/train/0001, since there
    may be a table/train/0001.off and a chair/test/0001.off. If both splits use the same numbers,
    unlike ModelNet10, chair/test/chair_0001.off is chair/test/chair_0001.
    """
    name_of_class = file.parent.parent.name
    own = file.stem.rpartition("_")[0] == name_of_class and not _is_of_both_splits(file)
    return file.stem if own else f"{name_of_class}/{file.parent.name}/{file.stem}"


def _is_of_both_splits(file: Path) -> bool:
    """Whether a test file has the name of a training file of its class.

    Training objects keep their names if test files are added, because networks store the names.
    """
    if file.parent.name != "test":
        return False
    train = file.parent.parent / "train"
    return file.stem in _stems(train, train.stat().st_mtime_ns if train.is_dir() else 0)


@lru_cache(maxsize=1024)
def _stems(folder: Path, changed_ns: int) -> frozenset[str]:  # noqa: ARG001 - else it is another folder
    """Hash of the names and states of the files in a folder."""
    return frozenset(file.stem for file in folder.glob("*") if is_object_file(file))


def _fingerprint(files: list[Path]) -> str:
    state = hashlib.sha256(f"{VERSION} {POINTS} {CANDIDATES}".encode())
    for file in files:
        facts = file.stat()
        state.update(os.fsencode(file.resolve()))
        state.update(f" {facts.st_size} {facts.st_mtime_ns}\n".encode())
        # The path determines everything except whether both splits share a name.
        if _is_of_both_splits(file):
            state.update(b"of both splits\n")
    return state.hexdigest()[:32]
