"""Sources of objects for simulated robots: procedural furniture and data sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Self

import numpy as np

from circumspect.datasets import open_data_set
from circumspect.datasets.catalogue import read_catalogue
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.scan_sources import PointSurfaces, ProceduralSurfaces, of_point_set
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES
from circumspect.geometry import TriangleMesh
from circumspect.simulation import surface_from_points

Split = Literal["train", "test"]
FURNITURE = "furniture"
"""Name of the source of procedural furniture."""
SPARE = 3
"""Pieces of furniture that are made per requested piece."""
FIRST_VARIANTS: Mapping[Split, int] = {"train": 200_000, "test": 250_000}
"""First variant of the furniture; used by nothing else."""


@dataclass(frozen=True, eq=False)
class ObjectSource:
    """Objects of one origin, split into training and test objects.

    Attributes:
        name: Of the origin, such as "modelnet10".
        train: Objects of the training split, in the order in which they are taken.
        test: Those of the test split.
    """

    name: str
    train: LabelledSurfaces
    test: LabelledSurfaces

    @classmethod
    def procedural(cls, counts: Mapping[Split, int]) -> Self:
        """Procedural furniture.

        Args:
            counts: Split to the number of pieces of each class.
        """
        return cls(FURNITURE, _furniture("train", counts), _furniture("test", counts))

    @classmethod
    def read(cls, path: Path) -> Self:
        """Objects of a data set.

        Args:
            path: A folder of point packs or of OFF files in the layout of ModelNet10, whose points
                become surfaces; or a mesh pack, in which one of six objects is for tests.

        Raises:
            InputError: Nothing of that kind is there, or it is broken.
        """
        if path.is_file():
            surfaces = read_catalogue(path)
            test = surfaces.held_back()
            return cls(
                path.stem, _shuffled(surfaces.subset(~test)), _shuffled(surfaces.subset(test))
            )
        train = of_point_set(open_data_set(path, "train"))
        test = of_point_set(open_data_set(path, "test"))
        return cls(path.name, _shuffled(_solid(train)), _shuffled(_solid(test)))


@dataclass(frozen=True, eq=False)
class SolidSurfaces:
    """Surfaces through points, without holes for rays.

    Attributes:
        points: Their points, in metres.
    """

    points: PointSurfaces

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        points, objects = self.points.points_in_metres(index), self.points.objects
        label = objects.classes[int(objects.labels[index])]
        return surface_from_points(points, label, float(np.ptp(points, axis=0).max()))


def _solid(surfaces: LabelledSurfaces) -> LabelledSurfaces:
    assert isinstance(surfaces.source, PointSurfaces)
    return replace(surfaces, source=SolidSurfaces(surfaces.source))


def _furniture(split: Split, counts: Mapping[Split, int]) -> LabelledSurfaces:
    # More than requested, since those that equal a test object are left out.
    count, first = SPARE * counts[split], FIRST_VARIANTS[split]
    items = tuple((label, first + number) for number in range(count) for label in CATEGORIES)
    names = [f"{label}-{variant}" for label, variant in items]
    return LabelledSurfaces(
        ProceduralSurfaces(items), np.arange(len(items)),
        np.array([label for label, _ in items], np.str_), np.array(names, np.str_), "",
    )  # fmt: skip


def _shuffled(surfaces: LabelledSurfaces) -> LabelledSurfaces:
    """Order by a hash of the names, since neighbours in a data set are often alike."""
    hashes = surfaces.hashes()
    return surfaces.subset(np.array(sorted(range(len(surfaces)), key=hashes.__getitem__), np.int64))


def sources_of(names: Sequence[str], counts: Mapping[Split, int]) -> list[ObjectSource]:
    """Sources by the names that a user gives.

    Args:
        names: "furniture", or paths of data sets.
        counts: Split to the number of objects of each class.

    Raises:
        InputError: There is no such data set, or two have one name.
    """
    found = [
        ObjectSource.procedural(counts) if name == FURNITURE else ObjectSource.read(Path(name))
        for name in dict.fromkeys(names)
    ]
    known = [source.name for source in found]
    if twice := sorted({name for name in known if known.count(name) > 1}):
        raise InputError(f"two sources are called {twice[0]}; rename one of the files or folders")
    return found
