"""Verification that a copy of ModelNet10 is complete and readable."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from circumspect.datasets.object_mesh import OFF_SUFFIXES, read_object_mesh
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.point_pack import read_point_pack
from circumspect.errors import CircumspectError, InputError

MODELNET10 = MappingProxyType(
    {
        "bathtub": (106, 50),
        "bed": (515, 100),
        "chair": (889, 100),
        "desk": (200, 86),
        "dresser": (200, 86),
        "monitor": (465, 100),
        "night_stand": (200, 86),
        "sofa": (680, 100),
        "table": (392, 100),
        "toilet": (344, 100),
    }
)
"""Numbers of training and test models per class, numbered consecutively, training first."""
SPLITS = ("train", "test")
NAME = re.compile(r"(\w+)_\d{4}")
"""Class and number in the name of a model."""


@dataclass(frozen=True)
class Verification:
    """The content of a copy.

    Attributes:
        counts: Number of models found, by split and class.
        missing: Split and name of each missing model.
        foreign: Files that do not belong to ModelNet10.
        broken: Path and error of files that are unreadable or contradictory.
    """

    counts: dict[tuple[str, str], int]
    missing: tuple[tuple[str, str], ...]
    foreign: tuple[str, ...]
    broken: tuple[tuple[str, str], ...]

    @property
    def complete(self) -> bool:
        """Whether nothing is missing or unreadable; other files do not matter."""
        return not self.missing and not self.broken

    def to_dict(self) -> dict[str, Any]:
        """The content in JSON types."""
        return {
            "complete": self.complete,
            "counts": {
                split: {name: self.counts.get((split, name), 0) for name in MODELNET10}
                for split in SPLITS
            },
            "missing": [f"{split}/{name}" for split, name in self.missing],
            "foreign": list(self.foreign),
            "broken": [{"file": file, "error": error} for file, error in self.broken],
        }


def expected_names() -> dict[str, list[str]]:
    """Names of all models by split."""
    names: dict[str, list[str]] = {split: [] for split in SPLITS}
    for name, (train, test) in MODELNET10.items():
        names["train"] += [f"{name}_{number:04d}" for number in range(1, train + 1)]
        names["test"] += [f"{name}_{number:04d}" for number in range(train + 1, train + test + 1)]
    return names


def verify(path: Path, progress: Callable[[int, int], None] | None = None) -> Verification:
    """Read a whole copy and compare it with ModelNet10.

    Args:
        path: A folder of point packs, or the folder of OFF files.
        progress: Called with (done, all) after each mesh.

    Raises:
        InputError: There are neither packs nor OFF files.
    """
    if any((path / f"{split}.npz").is_file() for split in SPLITS):
        return _of_packs(path)
    if not path.is_dir():
        raise InputError(f"{path}: no such folder; give point packs or the OFF folder")
    files = sorted(file for file in path.rglob("*") if file.is_file())
    if not any(file.suffix in OFF_SUFFIXES for file in files):
        raise InputError(f"{path}: neither point packs nor <class>/{{train,test}}/*.off below it")
    return _of_files(path, files, progress)


def _of_packs(path: Path) -> Verification:
    found: list[tuple[str, str]] = []
    broken = []
    for split in SPLITS:
        pack = path / f"{split}.npz"
        try:
            objects = read_point_pack(pack)
        except InputError as error:
            broken.append((pack.name, str(error)))
            continue
        found += [(split, str(name)) for name in objects.names]
        for error in (_mislabelled(objects), _misplaced(objects, split)):
            if error is not None:
                broken.append((pack.name, f"{pack}: {error}"))
    return _compared(found, [], broken)


def _mislabelled(objects: ObjectSet) -> str | None:
    """Describe labels that disagree with the names of their objects; None if all agree."""
    labels = [objects.classes[label] for label in objects.labels]
    wrong = [
        (str(name), label)
        for name, label in zip(objects.names, labels, strict=True)
        if (named := NAME.fullmatch(str(name))) and named[1] in MODELNET10 and named[1] != label
    ]
    if not wrong:
        return None
    name, label = wrong[0]
    return (
        f"{len(wrong)} of {len(labels)} labels disagree with the names, as that of {name}, which "
        f"is {label}; fetch or make the pack again"
    )


def _misplaced(objects: ObjectSet, split: str) -> str | None:
    """Describe repeated objects and objects of the other split."""
    counts = Counter(objects.names.tolist())
    if twice := sorted(name for name, count in counts.items() if count > 1):
        return f"{len(twice)} objects are in it more than once, as {twice[0]} is"
    names = expected_names()
    foreign = {name for other in SPLITS if other != split for name in names[other]}
    if wrong := sorted(foreign & counts.keys()):
        return f"{len(wrong)} objects belong to the other split, as {wrong[0]} does"
    return None


def _of_files(
    path: Path, files: list[Path], progress: Callable[[int, int], None] | None
) -> Verification:
    known = {split: set(names) for split, names in expected_names().items()}
    found, foreign, broken = [], [], []
    for done, file in enumerate(files, start=1):
        place = file.relative_to(path)
        split = place.parts[1] if len(place.parts) == 3 else ""
        name_of_class = file.stem.rpartition("_")[0]
        belongs = file.stem in known.get(split, ()) and place.parts[0] == name_of_class
        if not belongs or file.suffix not in OFF_SUFFIXES:
            foreign.append(str(place))
        else:
            try:
                read_object_mesh(file)
                found.append((split, file.stem))
            except CircumspectError as error:
                broken.append((str(place), str(error)))
        if progress:
            progress(done, len(files))
    return _compared(found, foreign, broken)


def _compared(
    found: Iterable[tuple[str, str]], foreign: list[str], broken: list[tuple[str, str]]
) -> Verification:
    there = set(found)
    expected = {(split, name) for split, names in expected_names().items() for name in names}
    counts = Counter((split, name.rpartition("_")[0]) for split, name in there & expected)
    beside = [f"{split}/{name}" for split, name in sorted(there - expected)]
    unreadable = {(Path(file).parts[-2], Path(file).stem) for file, _ in broken if "/" in file}
    missing = sorted(expected - there - unreadable)
    return Verification(dict(counts), tuple(missing), (*foreign, *beside), tuple(broken))
