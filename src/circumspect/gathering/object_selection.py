"""Select objects from several sources: equal numbers of each class for each split."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.validation_split import cells_and_beside, turned
from circumspect.errors import GeometryError, InputError
from circumspect.gathering.object_source import ObjectSource, Split
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.simulation import Orbit

SAMPLES = 4096
"""Points of an object for comparison with others."""
QUARTER_TURNS = 4
"""Turns in which objects are compared, since sources differ in the direction of the front."""
SAME_MODEL = 0.98
"""Overlap of equal models: 80 objects that were sampled twice overlap with themselves by 0.983 to
0.998 (`cells_and_beside`), different ones of a class by 0.5 to 0.99."""


@dataclass(frozen=True, eq=False)
class SelectedObject:
    """An object to scan.

    Attributes:
        name: Without characters that names of files or scans cannot hold.
        label: Its class.
        split: Its split.
        source: Name of its source.
        surfaces: The source's objects.
        index: Its index in the source.
    """

    name: str
    label: str
    split: Split
    source: str
    surfaces: LabelledSurfaces
    index: int

    def mesh(self) -> TriangleMesh:
        """Its surface [m], standing on z = 0."""
        return self.surfaces.mesh(self.index)


@dataclass(eq=False)
class _Shapes:
    """Shapes of test objects of one class, to find equal models among the training objects."""

    occupied: list[NDArray[np.float32]] = field(default_factory=list)
    beside: list[NDArray[np.float32]] = field(default_factory=list)

    def add(self, mesh: TriangleMesh) -> None:
        cells, near = cells_and_beside(mesh.sampled(SAMPLES))
        self.occupied.append(cells.ravel())
        self.beside.append(near.ravel())

    def contain_same_model(self, mesh: TriangleMesh) -> bool:
        """Whether one of the shapes is the same model, in any quarter turn."""
        if not self.occupied:
            return False
        cells, near = cells_and_beside(mesh.sampled(SAMPLES))
        every = cells.shape[1] // QUARTER_TURNS
        known, beside = np.stack(self.occupied), np.stack(self.beside)
        # Not by BLAS, whose threads wait for each other for minutes if all cores are busy.
        there = np.einsum("tc,nc->tn", turned(cells, every), beside) / cells.sum()
        back = np.einsum("tc,nc->tn", turned(near, every), known) / known.sum(axis=1)
        return bool((np.minimum(there, back) >= SAME_MODEL).any())


def select_objects(
    sources: Sequence[ObjectSource],
    classes: Sequence[str],
    counts: Mapping[Split, int],
    progress: Callable[[int, int], None] | None = None,
) -> list[SelectedObject]:
    """Select objects; the sources alternate, and the others continue if one is exhausted.

    Objects that do not fit the camera's image are left out, and so are training objects that equal
    a test object.

    Args:
        sources: Sources of objects.
        classes: Classes of the objects.
        counts: Split to the number of objects of each class.
        progress: Called with (done, all).

    Returns:
        Class by class, test objects before training objects.

    Raises:
        InputError: The sources hold too few objects of a class, or two with the same name.
    """
    known = {label for source in sources for part in (source.train, source.test)
             for label in part.labels.tolist()}  # fmt: skip
    if unknown := [label for label in classes if label not in known]:
        raise InputError(
            f"no source has objects of class {unknown[0]}; there are {', '.join(sorted(known))}"
        )
    total, chosen = len(classes) * sum(counts.values()), list[SelectedObject]()
    for label in classes:
        shapes = _Shapes()
        for split in ("test", "train"):
            found = 0
            for candidate in _candidates(sources, label, split):
                if found == counts[split]:
                    break
                if not _is_suitable(candidate, shapes):
                    continue
                found += 1
                chosen.append(candidate)
                if progress is not None:
                    progress(len(chosen), total)
            if found < counts[split]:
                raise InputError(
                    f"{found} objects of class {label} to {split} with; {counts[split]} are "
                    "requested: give more --sources, such as furniture, or request fewer"
                )
    _require_names(chosen)
    return chosen


def _candidates(
    sources: Sequence[ObjectSource], label: str, split: Split
) -> Iterator[SelectedObject]:
    """Objects of a class, alternating between the sources."""
    for in_turn in zip_longest(*(_of_class(source, label, split) for source in sources)):
        yield from (one for one in in_turn if one is not None)


def _of_class(source: ObjectSource, label: str, split: Split) -> Iterator[SelectedObject]:
    surfaces = source.train if split == "train" else source.test
    for index in np.flatnonzero(surfaces.labels == label).tolist():
        name = object_name(str(surfaces.names[index]))
        yield SelectedObject(name, label, split, source.name, surfaces, index)


def _is_suitable(candidate: SelectedObject, shapes: _Shapes) -> bool:
    mesh = candidate.mesh()
    try:
        Orbit.around(mesh, PinholeCamera.xtion())
        if candidate.split == "test":
            shapes.add(mesh)
            return True
        return not shapes.contain_same_model(mesh)
    except (InputError, GeometryError):
        return False


def object_name(name: str) -> str:
    """The name of a source's object in a gathered set."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._")


def _require_names(chosen: Sequence[SelectedObject]) -> None:
    known: dict[str, SelectedObject] = {}
    for one in chosen:
        other = known.setdefault(one.name, one)
        if other is not one:
            raise InputError(
                f"{other.source} ({other.split}) and {one.source} ({one.split}) both hold an "
                f"object {one.name}"
            )
