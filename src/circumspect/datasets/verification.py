"""Whether a copy of ModelNet10 is complete and sound."""

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
"""Training and test models of each class; those of a class are numbered through, training first."""
SPLITS = ("train", "test")
NAME = re.compile(r"(\w+)_\d{4}")
"""Of a model: its class and its number."""


@dataclass(frozen=True)
class Verification:
    """What a copy holds.

    Attributes:
        counts: Split and class to models found.
        missing: Split and name of each model that is not there.
        foreign: What does not belong to ModelNet10.
        broken: Path and fault of what can not be read, or says two things at once.
    """

    counts: dict[tuple[str, str], int]
    missing: tuple[tuple[str, str], ...]
    foreign: tuple[str, ...]
    broken: tuple[tuple[str, str], ...]

    @property
    def complete(self) -> bool:
        """Everything is there and can be read; what is there beside does no harm."""
        return not self.missing and not self.broken

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
        return {
            "complete": self.complete,
            "counts": {
                split: {name: self.counts.get((split, name), 0) for name in MODELNET10}
                for split in SPLITS
            },
            "missing": [f"{split}/{name}" for split, name in self.missing],
            "foreign": list(self.foreign),
            "broken": [{"file": file, "fault": fault} for file, fault in self.broken],
        }


def expected_names() -> dict[str, list[str]]:
    """Split to the names of all its models."""
    names: dict[str, list[str]] = {split: [] for split in SPLITS}
    for name, (train, test) in MODELNET10.items():
        names["train"] += [f"{name}_{number:04d}" for number in range(1, train + 1)]
        names["test"] += [f"{name}_{number:04d}" for number in range(train + 1, train + test + 1)]
    return names


def verify(path: Path, progress: Callable[[int, int], None] | None = None) -> Verification:
    """Read all of a copy and compare it with what ModelNet10 is made of.

    Args:
        path: A folder of point packs, or the folder of OFF files.
        progress: Called with (done, all) after each mesh.

    Raises:
        InputError: Neither is there.
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
        for fault in (_mislabelled(objects), _misplaced(objects, split)):
            if fault is not None:
                broken.append((pack.name, f"{pack}: {fault}"))
    return _compared(found, [], broken)


def _mislabelled(objects: ObjectSet) -> str | None:
    """How many labels say otherwise than the names of their objects; None where all agree."""
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
        f"is {label}; fetch or make the pack anew"
    )


def _misplaced(objects: ObjectSet, split: str) -> str | None:
    """What a pack holds twice, or of the other split; unlike a file beside, it would be used."""
    counts = Counter(objects.names.tolist())
    if twice := sorted(name for name, count in counts.items() if count > 1):
        return f"{len(twice)} objects are in it more than once, as {twice[0]} is"
    names = expected_names()
    strangers = {name for other in SPLITS if other != split for name in names[other]}
    if wrong := sorted(strangers & counts.keys()):
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
