"""Labelled meshes with real sizes, packed in memory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.packed_mesh import PackedMesh
from circumspect.errors import InputError
from circumspect.geometry import TriangleMesh
from circumspect.geometry.frozen_array import ReadOnlyArrays

OTHER = -1
"""Label of an object that belongs to none of the classes."""
AMBIGUOUS = -2
"""Label of an object that may belong to a class; left out of training."""
OTHER_LABEL = "other"
MAX_LENGTH_M = 1e6
"""Maximum size, scale and offset [m]; larger ones are in a wrong unit."""

_TEXTS = ("names", "categories", "catalogues", "licences", "creators", "model paths")


@dataclass(frozen=True)
class MeshEntry:
    """One mesh of a pack with its record.

    Attributes:
        packed: The mesh, z up, standing on z = 0, front towards -y.
        label: Index into the pack's classes, `OTHER` or `AMBIGUOUS`.
        metres: Width, depth and height [m].
        furniture_size: Whether it has the size of furniture.
        title: Title in the catalogue, such as "Armchair"; not unique.
        category: Category in the catalogue, such as "Living room".
        catalogue: Name of the catalogue.
        licence: Licence of the model.
        creator: Creator to attribute.
        model_id: Path of the model within the catalogue.
    """

    packed: PackedMesh
    label: int
    metres: tuple[float, float, float]
    furniture_size: bool
    title: str
    category: str = ""
    catalogue: str = ""
    licence: str = ""
    creator: str = ""
    model_id: str = ""


@dataclass(frozen=True)
class MeshObject:
    """A training object.

    Attributes:
        name: Name, unique within the pack.
        label: Name of its class, or "other".
        packed: The packed mesh.
    """

    name: str
    label: str
    packed: PackedMesh

    @property
    def mesh(self) -> TriangleMesh:
        """The mesh [m], z up, standing on z = 0; unpacked at every call."""
        return self.packed.mesh()


@dataclass(frozen=True, eq=False)
class MeshSet(ReadOnlyArrays):
    """Labelled meshes with real sizes, unpacked on access.

    Attributes:
        vertices_u16: (v, 3) uint16 vertices of all meshes.
        faces: (f, 3) indices into the vertices of their own mesh.
        vertex_starts: (n + 1,) index of the first vertex of each mesh.
        face_starts: (n + 1,) index of the first face of each mesh.
        offset: (n, 3) [m] lowest x, y and z.
        scale: (n,) [m] longest side.
        labels: (n,) index into `classes`, `OTHER` or `AMBIGUOUS`.
        metres: (n, 3) width, depth and height [m].
        furniture_size: (n,) whether each mesh has the size of furniture.
        titles: (n,) titles in the catalogues; not unique.
        categories: (n,) categories in the catalogues.
        catalogues: (n,) names of the catalogues.
        licences: (n,) licences of the models.
        creators: (n,) creators to attribute.
        model_ids: (n,) paths within the catalogues.
        classes: Names of the classes.

    Raises:
        InputError: The arrays do not match, or an index is out of range.
    """

    vertices_u16: NDArray[np.uint16]
    faces: NDArray[np.integer]
    vertex_starts: NDArray[np.integer]
    face_starts: NDArray[np.integer]
    offset: NDArray[np.float64]
    scale: NDArray[np.float64]
    labels: NDArray[np.integer]
    metres: NDArray[np.floating]
    furniture_size: NDArray[np.bool_]
    titles: NDArray[np.str_]
    categories: NDArray[np.str_]
    catalogues: NDArray[np.str_]
    licences: NDArray[np.str_]
    creators: NDArray[np.str_]
    model_ids: NDArray[np.str_]
    classes: tuple[str, ...]

    def __post_init__(self) -> None:
        _require_shapes(self)
        _require_starts(self.vertex_starts, len(self.vertices_u16), "vertices")
        _require_starts(self.face_starts, len(self.faces), "faces")
        _require_faces(self)
        _require_numbers(self)

    def __len__(self) -> int:
        return len(self.labels)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Unique names: catalogue and path, with a number if several meshes share them."""
        given = [f"{a}/{b}" for a, b in zip(self.catalogues, self.model_ids, strict=True)]
        return _unique(given)

    @property
    def texts(self) -> tuple[NDArray[np.str_], ...]:
        """Titles, categories, catalogues, licences, creators and paths."""
        return (
            self.titles, self.categories, self.catalogues,
            self.licences, self.creators, self.model_ids,
        )  # fmt: skip

    @property
    def labelled(self) -> tuple[MeshObject, ...]:
        """The objects of the classes."""
        return self._objects(self.labels >= 0)

    @property
    def others(self) -> tuple[MeshObject, ...]:
        """The objects of no class that have the size of furniture."""
        return self._objects((self.labels == OTHER) & self.furniture_size)

    def mesh(self, index: int) -> TriangleMesh:
        """One mesh [m], z up, standing on z = 0, front towards -y."""
        return self.packed(index).mesh()

    def packed(self, index: int) -> PackedMesh:
        """One packed mesh; its arrays are views.

        Raises:
            IndexError: There is no such mesh.
        """
        if not 0 <= index < len(self):
            raise IndexError(f"mesh {index} of {len(self)}")
        vertices = slice(self.vertex_starts[index], self.vertex_starts[index + 1])
        faces = slice(self.face_starts[index], self.face_starts[index + 1])
        return PackedMesh(
            self.vertices_u16[vertices],
            self.faces[faces],
            self.offset[index],
            float(self.scale[index]),
        )

    def entry(self, index: int) -> MeshEntry:
        """One mesh with its record, for `write_mesh_pack`.

        Raises:
            IndexError: There is no such mesh.
        """
        width, depth, height = (float(side) for side in self.metres[index])
        return MeshEntry(
            self.packed(index),
            int(self.labels[index]),
            (width, depth, height),
            bool(self.furniture_size[index]),
            *(str(column[index]) for column in self.texts),
        )

    def _objects(self, chosen: NDArray[np.bool_]) -> tuple[MeshObject, ...]:
        return tuple(
            MeshObject(self.names[i], self._label(i), self.packed(i))
            for i in map(int, np.flatnonzero(chosen))
        )

    def _label(self, index: int) -> str:
        label = int(self.labels[index])
        return self.classes[label] if label >= 0 else OTHER_LABEL


def _unique(names: list[str]) -> tuple[str, ...]:
    """The names, with numbers for repeated ones."""
    taken = set(names)
    next_number: dict[str, int] = {}
    unique = []
    for name in names:
        candidate = name
        if name in next_number:
            while candidate in taken:
                candidate = f"{name}#{next_number[name]}"
                next_number[name] += 1
            taken.add(candidate)
        next_number.setdefault(name, 2)
        unique.append(candidate)
    return tuple(unique)


def _require_shapes(meshes: MeshSet) -> None:
    n = meshes.labels.shape[0] if meshes.labels.ndim else 0
    if meshes.labels.ndim != 1 or n == 0:
        raise InputError(f"labels must have shape (n,), n >= 1, not {meshes.labels.shape}")
    expected = {
        "vertex offsets": (meshes.vertex_starts, (n + 1,)),
        "face offsets": (meshes.face_starts, (n + 1,)),
        "offset": (meshes.offset, (n, 3)),
        "scale": (meshes.scale, (n,)),
        "sizes": (meshes.metres, (n, 3)),
        "furniture_size": (meshes.furniture_size, (n,)),
        **{key: (texts, (n,)) for key, texts in zip(_TEXTS, meshes.texts, strict=True)},
    }
    for key, (array, shape) in expected.items():
        if array.shape != shape:
            raise InputError(
                f"{key} must have shape {shape}, as there are {n} labels, not {array.shape}"
            )
    for key, array in (("vertices", meshes.vertices_u16), ("faces", meshes.faces)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise InputError(f"{key} must have shape (m, 3), not {array.shape}")
    if not meshes.classes or len(set(meshes.classes)) < len(meshes.classes):
        raise InputError("classes must hold at least one name, and none twice")


def _require_starts(starts: NDArray[np.integer], count: int, what: str) -> None:
    """Check that the starts begin at 0, end with the last index and increase."""
    if starts[0] != 0 or starts[-1] != count:
        raise InputError(
            f"the offsets of {what} run from {starts[0]} to {starts[-1]}, not from 0 to {count}"
        )
    if not (starts[1:] > starts[:-1]).all():
        raise InputError(f"the offsets of {what} do not increase; each mesh has at least one")


def _require_faces(meshes: MeshSet) -> None:
    highest = np.maximum.reduceat(meshes.faces.ravel(), 3 * meshes.face_starts[:-1])
    counts = meshes.vertex_starts[1:] - meshes.vertex_starts[:-1]
    low = int(meshes.faces.min())
    if low < 0:
        raise InputError(f"a face names vertex {low}")
    if (beyond := np.flatnonzero(highest >= counts)).size:
        i = int(beyond[0])
        raise InputError(
            f"mesh {i} ({meshes.titles[i]}): a face names vertex {highest[i]}, but the vertices "
            f"are 0 … {counts[i] - 1}"
        )


def _require_numbers(meshes: MeshSet) -> None:
    sound = {
        "scale": (meshes.scale > 0) & (meshes.scale <= MAX_LENGTH_M),
        "offset": (np.abs(meshes.offset) <= MAX_LENGTH_M).all(axis=1),
        "sizes": ((meshes.metres >= 0) & (meshes.metres <= MAX_LENGTH_M)).all(axis=1),
        "the label": (meshes.labels >= AMBIGUOUS) & (meshes.labels < len(meshes.classes)),
    }
    for key, fine in sound.items():
        if not fine.all():
            i = int(np.flatnonzero(~fine)[0])
            raise InputError(f"mesh {i} ({meshes.titles[i]}): {key} is out of range")
