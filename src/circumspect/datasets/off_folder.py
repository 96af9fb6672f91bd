"""The folder that ModelNet10's archive unpacks to: `<class>/{train,test}/<class>_NNNN.off`."""

from __future__ import annotations

import hashlib
import logging
import os
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.farthest_points import CANDIDATES, POINTS, evenly_sampled
from circumspect.datasets.object_mesh import SUFFIXES, read_object_mesh
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.point_pack import read_point_pack, write_point_pack
from circumspect.datasets.verification import MODELNET10, NAME
from circumspect.errors import InputError, printable

VERSION = 3
log = logging.getLogger(__name__)


def read_off_folder(
    folder: Path, split: str, progress: Callable[[int, int], None] | None = None
) -> ObjectSet:
    """Sample every mesh of one split; the result is cached as a point pack.

    What seems to be a copy of ModelNet10 but holds files that are not named after their class is
    read all the same, and a warning logged.

    Args:
        folder: Holds one folder a class.
        split: "train" or "test".
        progress: Called with (done, all) after each mesh.

    Raises:
        InputError: No such split, two files of one name, or a mesh that can not be read.
    """
    files = off_files(folder, split)
    if not files:
        raise InputError(f"{folder}: no <class>/{split}/*.off below it")
    _warn_of_strangers(folder, split, files)
    cached = cache_folder("packs") / f"{_fingerprint(files)}.npz"
    with suppress(InputError):
        return read_point_pack(cached)
    objects = _sample(files, progress)
    write_point_pack(cached, objects)
    log.info("%s: %d meshes sampled, kept as %s", folder, len(objects), cached)
    # Quantised like every later read: else what was made of this one would not fit to those.
    return read_point_pack(cached)


def off_files(folder: Path, split: str) -> list[Path]:
    """The meshes of one split, in order.

    Raises:
        InputError: Two differ in the case of their suffix alone, and would be one object.
    """
    files = sorted(file for file in folder.glob(f"*/{split}/*") if file.suffix in SUFFIXES)
    counts = Counter(file.with_suffix("") for file in files)
    if twice := [str(stem) for stem, count in counts.items() if count > 1]:
        raise InputError(f"{' and '.join(twice[0] + end for end in SUFFIXES)}: remove one of them")
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
    with ThreadPoolExecutor() as pool:
        for done, (sample, side) in enumerate(pool.map(_sampled, files), start=1):
            points[done - 1], sides[done - 1] = sample, side
            if progress:
                progress(done, len(files))
    labels = np.array([classes.index(file.parent.parent.name) for file in files], np.int64)
    names = np.array([object_name(file) for file in files])
    return ObjectSet(points, labels, names, classes, sides=sides)


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
    train = file.parent.parent / "train"
    named_alike = (train / f"{file.stem}{suffix}" for suffix in SUFFIXES)
    return file.parent.name == "test" and any(map(Path.exists, named_alike))


def sampled_file(file: Path) -> NDArray[np.float32]:
    """(1024, 3) evenly spread points of one mesh, in units of its longest side.

    Raises:
        InputError: It can not be read, or has no area.
    """
    return _sampled(file)[0]


def _sampled(file: Path) -> tuple[NDArray[np.float32], float]:
    """The points of one mesh, and its longest side in the unit of the file."""
    mesh = read_object_mesh(file)
    return evenly_sampled(mesh), float(np.ptp(mesh.vertices_xyz, axis=0).max())


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
