"""A folder of objects, `<class>/{train,test}/*`: ModelNet10's, or one of own classes."""

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

    Files are of any readable format. Sizes are in metres where the format says so.

    What seems to be a copy of ModelNet10 but holds files that are not named after their class is
    read all the same, and a warning logged.

    Args:
        folder: Holds one folder a class.
        split: "train" or "test".
        progress: Called with (done, all) after each file.

    Raises:
        InputError: No such split, two files of one name, or a file that can not be read.
    """
    files = object_files(folder, split)
    if not files:
        raise InputError(
            f"{folder}: no <class>/{split}/*.off below it, nor files of another readable format"
        )
    _warn_of_strangers(folder, split, files)
    cached = cache_folder("packs") / f"{_fingerprint(files)}.npz"
    with suppress(InputError):
        return read_point_pack(cached)
    objects = _sample(files, progress)
    write_point_pack(cached, objects)
    log.info("%s: %d objects sampled, kept as %s", folder, len(objects), cached)
    # Quantised like every later read: else what was made of this one would not fit to those.
    return read_point_pack(cached)


def object_files(folder: Path, split: str) -> list[Path]:
    """The objects of one split, in order.

    Raises:
        InputError: Two differ in their suffix alone, and would be one object.
    """
    files = sorted(file for file in folder.glob(f"*/{split}/*") if is_object_file(file))
    named: dict[Path, Path] = {}
    for file in files:
        other = named.setdefault(file.with_suffix(""), file)
        if other is not file:
            raise InputError(f"{other} and {file}: one object in two files; remove one of them")
    return files


def _warn_of_strangers(folder: Path, split: str, files: list[Path]) -> None:
    """A sofa among the chairs is one of them to whoever goes by the folders alone.

    Folders of other classes may name their files as they like.
    """
    if {file.parent.parent.name for file in files} != set(MODELNET10):
        return
    strangers = [file for file in files if not _is_named_after_its_class(file)]
    if strangers:
        log.warning(
            "%s: %d of %d %s files bear names foreign to their class folder, such as %s; "
            "circumspect data verify %s names them",
            printable(str(folder)), len(strangers), len(files), split,
            printable(str(strangers[0].relative_to(folder))), printable(str(folder)),
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
    """What the object in a file is called, unlike any of another class or split.

    chair/train/chair_0001.off is chair_0001; chair/train/0001.off is chair/train/0001, since there
    may be a table/train/0001.off and a chair/test/0001.off. Where the splits are numbered anew,
    unlike ModelNet10's, chair/test/chair_0001.off is chair/test/chair_0001.
    """
    name_of_class = file.parent.parent.name
    own = file.stem.rpartition("_")[0] == name_of_class and not _is_of_both_splits(file)
    return file.stem if own else f"{name_of_class}/{file.parent.name}/{file.stem}"


def _is_of_both_splits(file: Path) -> bool:
    """Whether a test file is named like a training file of its class.

    What trains keeps its name whatever tests come later: networks remember it.
    """
    if file.parent.name != "test":
        return False
    train = file.parent.parent / "train"
    return file.stem in _stems(train, train.stat().st_mtime_ns if train.is_dir() else 0)


@lru_cache(maxsize=1024)
def _stems(folder: Path, changed_ns: int) -> frozenset[str]:  # noqa: ARG001 - else it is another folder
    """Names of the objects in a folder, as it is at a time."""
    return frozenset(file.stem for file in folder.glob("*") if is_object_file(file))


def _fingerprint(files: list[Path]) -> str:
    state = hashlib.sha256(f"{VERSION} {POINTS} {CANDIDATES}".encode())
    for file in files:
        facts = file.stat()
        state.update(os.fsencode(file.resolve()))
        state.update(f" {facts.st_size} {facts.st_mtime_ns}\n".encode())
        # The only part of a name that the path alone does not tell.
        if _is_of_both_splits(file):
            state.update(b"of both splits\n")
    return state.hexdigest()[:32]
