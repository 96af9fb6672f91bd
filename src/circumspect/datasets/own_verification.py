"""Verification that a set of own classes is readable; its expected content is unknown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circumspect.datasets.object_mesh import (
    COMPANIONS,
    OFF_SUFFIXES,
    is_object_file,
    require_object,
)
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.point_pack import KINDS, read_point_pack
from circumspect.datasets.verification import MODELNET10, NAME, SPLITS, expected_names
from circumspect.errors import CircumspectError, InputError
from circumspect.geometry.formats.npy_stream import read_arrays


@dataclass(frozen=True)
class OwnVerification:
    """The content of a set of own classes.

    Attributes:
        classes: Class names in alphabetical order.
        counts: Number of readable objects, by split and class.
        foreign: Files that do not belong to the set.
        broken: Path and error of files that are unreadable or contradictory.
    """

    classes: tuple[str, ...]
    counts: dict[tuple[str, str], int]
    foreign: tuple[str, ...]
    broken: tuple[tuple[str, str], ...]

    @property
    def complete(self) -> bool:
        """Whether the set is not empty and entirely readable."""
        return not self.broken and any(self.counts.values())

    def to_dict(self) -> dict[str, Any]:
        """The content in JSON types."""
        return {
            "complete": self.complete,
            "own_classes": True,
            "counts": {
                split: {name: self.counts.get((split, name), 0) for name in self.classes}
                for split in SPLITS
            },
            "missing": [],
            "foreign": list(self.foreign),
            "broken": [{"file": file, "error": error} for file, error in self.broken],
        }


def has_own_classes(path: Path) -> bool:
    """Whether a set has own classes and is not a copy of ModelNet10.

    A copy of ModelNet10 may lack classes and contain other files, but it has at least half of the
    models of one class under their names, or its folder is named ModelNet10. If all packs are
    unreadable, they are reported as such, not as an empty ModelNet10.
    """
    if "modelnet10" in path.absolute().name.lower():
        return False
    packs = _packs(path)
    meshes = [] if packs else list(_meshes(path))
    if not packs and not meshes:
        return False
    found = Counter(
        named[1] for name in _own_names(packs, meshes) if (named := NAME.fullmatch(name))
    )
    return not any(2 * found[name] >= sum(counts) for name, counts in MODELNET10.items())


def _own_names(packs: dict[str, Path], meshes: list[Path]) -> set[str]:
    """Names of ModelNet10's models in a set, in the folders of their classes."""
    models = {name for names in expected_names().values() for name in names}
    if packs:
        return models & set(_names_in_packs(packs))
    placed = (file for file in meshes if file.suffix in OFF_SUFFIXES)
    return models & {file.stem for file in placed if file.stem.startswith(f"{file.parts[0]}_")}


def verify_own(path: Path, progress: Callable[[int, int], None] | None = None) -> OwnVerification:
    """Read a whole set and count its classes and splits.

    Args:
        path: A folder of point packs, or of files <class>/{train,test}/* of any readable format.
        progress: Called with (done, all) after each file.
    """
    packs = _packs(path)
    return _of_packs(packs, progress) if packs else _of_files(path, progress)


def _packs(path: Path) -> dict[str, Path]:
    """Existing packs by split."""
    files = {split: path / f"{split}.npz" for split in SPLITS}
    return {split: file for split, file in files.items() if file.is_file()}


def _meshes(path: Path) -> Iterator[Path]:
    """Files of <class>/{train,test}/*, relative to the set's folder."""
    for file in path.glob("*/*/*"):
        place = file.relative_to(path)
        # Includes folders and dangling links with such names, which no reader can read.
        if place.parts[1] in SPLITS and is_object_file(file):
            yield place


def _names_in_packs(packs: dict[str, Path]) -> Iterator[str]:
    for pack in packs.values():
        try:
            yield from map(str, read_arrays(pack, {"names": KINDS["names"]})["names"].flat)
        except InputError:
            continue  # Its error is reported when the pack is read.


def _suffix_duplicates(meshes: set[Path]) -> dict[Path, Path]:
    """Files that differ from another file only in their suffix, with the other file."""
    first: dict[Path, Path] = {}
    for file in sorted(meshes):
        first.setdefault(file.with_suffix(""), file)
    return {file: other for file in meshes if (other := first[file.with_suffix("")]) != file}


def _classes_of_packs(packs: dict[str, Path]) -> Iterator[str]:
    for pack in packs.values():
        try:
            yield from map(str, read_arrays(pack, {"classes": KINDS["classes"]})["classes"].flat)
        except InputError:
            continue  # Its error is reported when the pack is read.


def _of_packs(
    packs: dict[str, Path], progress: Callable[[int, int], None] | None
) -> OwnVerification:
    counts: Counter[tuple[str, str]] = Counter()
    broken: list[tuple[str, str]] = []
    for done, (split, pack) in enumerate(packs.items(), start=1):
        try:
            objects = read_point_pack(pack)
        except InputError as error:
            broken.append((pack.name, str(error)))
        else:
            counts.update((split, objects.classes[label]) for label in objects.labels)
            broken += [(pack.name, f"{pack}: {error}") for error in _errors(objects)]
        if progress:
            progress(done, len(packs))
    classes = {name for _, name in counts} | set(_classes_of_packs(packs))
    return OwnVerification(tuple(sorted(classes)), dict(counts), (), tuple(broken))


def _errors(objects: ObjectSet) -> Iterator[str]:
    """Repeated or contradictory entries of a readable pack."""
    counts = Counter(objects.names.tolist())
    if twice := sorted(name for name, count in counts.items() if count > 1):
        yield f"{len(twice)} objects are in it more than once, as {twice[0]} is"
    for name, label in zip(objects.names, objects.labels, strict=True):
        named = NAME.fullmatch(str(name))
        if named and named[1] in objects.classes and named[1] != objects.classes[label]:
            yield f"{name} is labelled {objects.classes[label]}; name or label is wrong"
            return


def _of_files(path: Path, progress: Callable[[int, int], None] | None) -> OwnVerification:
    meshes = set(_meshes(path))
    files = sorted(
        {*meshes, *(file.relative_to(path) for file in path.rglob("*") if file.is_file())}
    )
    counts: Counter[tuple[str, str]] = Counter()
    twins = _suffix_duplicates(meshes)
    foreign, broken = [], []
    for done, file in enumerate(files, start=1):
        if file not in meshes:
            # Materials and textures are stored beside their mesh.
            if file.suffix.lower() not in COMPANIONS or len(file.parts) < 3:
                foreign.append(str(file))
        else:
            try:
                if twin := twins.get(file):
                    raise InputError(f"{file}: the same object as {twin}; remove one of them")
                require_object(path / file)
                counts[file.parts[1], file.parts[0]] += 1
            except CircumspectError as error:
                broken.append((str(file), str(error)))
        if progress:
            progress(done, len(files))
    classes = sorted({file.parts[0] for file in meshes})
    return OwnVerification(tuple(classes), dict(counts), tuple(foreign), tuple(broken))
