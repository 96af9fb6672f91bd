"""Import of Sweet Home 3D's furniture catalogues as a mesh pack."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.mesh_pack import AMBIGUOUS, OTHER, MeshEntry
from circumspect.datasets.packed_mesh import PackedMesh
from circumspect.datasets.sweethome3d_catalogue import (
    Catalogue,
    ModelArchive,
    Piece,
    PieceError,
    SkipCode,
    catalogue_files,
    open_models,
    read_catalogue,
)
from circumspect.datasets.sweethome3d_classes import CLASSES, has_furniture_size, label_of
from circumspect.errors import InputError
from circumspect.geometry import TriangleMesh
from circumspect.geometry.formats.npy_stream import MAX_BYTES
from circumspect.geometry.formats.obj_file import parse_obj

MAX_PACK_BYTES = MAX_BYTES // 2
"""Maximum size of vertices and faces of all models [bytes]; a reader needs twice as much."""
SIDES = ("width", "depth", "height")
MAX_SIDE_M = 1000.0
"""Maximum side [m]; the largest trucks and pools have 20 m."""
ROTATION_TOLERANCE = 0.01
"""Tolerance of rotations, which have few digits in catalogues."""
# The program's x points to the right, y up and z to the viewer; here the front faces -y.
_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Skipped:
    """A skipped piece.

    Attributes:
        catalogue: Name of its catalogue.
        number: Number in the keys of its properties.
        title: Name in the catalogue.
        code: The reason as a code.
        reason: The reason in words.
    """

    catalogue: str
    number: int
    title: str
    code: SkipCode
    reason: str


@dataclass
class ImportedCatalogues:
    """The pieces of imported catalogues.

    Attributes:
        entries: The imported models.
        skipped: The skipped pieces.
        licences: Number of imported models by name and licence of the catalogue.
    """

    entries: list[MeshEntry] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)
    licences: Counter[tuple[str, str]] = field(default_factory=Counter)

    def to_dict(self) -> dict[str, Any]:
        """The content in JSON types."""
        labels = Counter(entry.label for entry in self.entries)
        others = [entry for entry in self.entries if entry.label == OTHER]
        return {
            "models": len(self.entries),
            "classes": {name: labels[index] for index, name in enumerate(CLASSES)},
            "others": len(others),
            "others_of_furniture_size": sum(entry.furniture_size for entry in others),
            "ambiguous": labels[AMBIGUOUS],
            "catalogues": [
                {"catalogue": name, "licence": licence, "models": count}
                for (name, licence), count in sorted(self.licences.items())
            ],
            "skipped": [
                {"catalogue": piece.catalogue, "number": piece.number, "name": piece.title,
                 "code": str(piece.code), "reason": piece.reason}
                for piece in self.skipped
            ],
        }  # fmt: skip


def import_sweethome3d(
    path: Path, progress: Callable[[int, int], None] | None = None
) -> ImportedCatalogues:
    """Read all models of catalogues.

    Unusable models, and duplicates of the same size, are skipped and recorded.

    Args:
        path: A .sh3f file, or a folder; see `catalogue_files`.
        progress: Called with (done, all) after each piece.

    Raises:
        InputError: A catalogue cannot be read, or no model can be imported.
    """
    # All properties are read first, to find a broken catalogue before the long work.
    catalogues = [read_catalogue(file) for file in catalogue_files(path)]
    total = sum(len(catalogue.pieces) for catalogue in catalogues)
    imported = ImportedCatalogues()
    seen: set[bytes] = set()
    size = 0
    for catalogue in catalogues:
        with open_models(catalogue.path) as models:
            for piece in catalogue.pieces:
                size += _take(imported, catalogue, models, piece, seen)
                if size > MAX_PACK_BYTES:
                    raise InputError(
                        f"{path}: its models take more than {MAX_PACK_BYTES >> 20} MiB; import "
                        "fewer catalogues at a time"
                    )
                if progress:
                    progress(len(imported.entries) + len(imported.skipped), total)
    if not imported.entries:
        raise InputError(f"{path}: {_why_empty(imported)}")
    return imported


def _take(
    imported: ImportedCatalogues,
    catalogue: Catalogue,
    models: ModelArchive,
    piece: Piece,
    seen: set[bytes],
) -> int:
    """Add a piece to the entries or to the skipped ones; return its size [bytes]."""
    try:
        entry = _entry(catalogue, models, piece, seen)
    except PieceError as error:
        imported.skipped.append(
            Skipped(catalogue.name, piece.number, piece.text("name"), error.code, str(error))
        )
        return 0
    imported.entries.append(entry)
    imported.licences[entry.catalogue, entry.licence] += 1
    return entry.packed.nbytes


def _entry(catalogue: Catalogue, models: ModelArchive, piece: Piece, seen: set[bytes]) -> MeshEntry:
    """A piece's model with its record.

    Raises:
        PieceError: The piece cannot be used.
    """
    title, category = piece.title, piece.text("category")
    metres, rotation = size_of(piece), rotation_of(piece)
    data = models.read(piece.model)
    digest = hashlib.sha256(repr((metres, rotation.tolist())).encode() + data).digest()
    if digest in seen:
        raise PieceError(SkipCode.DUPLICATE, "is the same model of the same size as an earlier one")
    packed = placed_model(data, metres, rotation)
    seen.add(digest)
    return MeshEntry(
        packed,
        label_of(title, category, metres),
        metres,
        has_furniture_size(category, metres),
        title=title,
        category=category,
        catalogue=catalogue.name,
        licence=piece.text("license") or catalogue.licence,
        creator=piece.text("creator"),
        model_id=piece.text("model").strip().lstrip("/"),
    )


def _why_empty(imported: ImportedCatalogues) -> str:
    if not imported.skipped:
        return "its catalogues list no furniture"
    first = imported.skipped[0]
    return (
        f"none of its {len(imported.skipped)} models can be used; number {first.number} "
        f"{first.reason}"
    )


def size_of(piece: Piece) -> tuple[float, float, float]:
    """Width, depth and height [m].

    Raises:
        PieceError: A value is missing, not a number, not positive or too large.
    """
    width, depth, height = (_side(piece, side) for side in SIDES)
    return width, depth, height


def rotation_of(piece: Piece) -> NDArray[np.float64]:
    """(3, 3) rotation of the model before it is scaled, in the program's axes.

    Raises:
        PieceError: The matrix is not a rotation.
    """
    text = piece.properties.get("modelRotation", "").strip()
    if not text:
        return np.eye(3)
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    rotation = np.array(numbers).reshape(3, 3) if len(numbers) == 9 else np.zeros((3, 3))
    if not _is_rotation(rotation):
        raise PieceError(SkipCode.BAD_ROTATION, "its modelRotation is no rotation of nine numbers")
    return rotation


def placed_model(
    data: bytes, metres: tuple[float, float, float], rotation: NDArray[np.float64]
) -> PackedMesh:
    """The mesh of an OBJ file, rotated and scaled by the properties.

    Args:
        data: The file.
        metres: Width, depth and height [m] of the result.
        rotation: (3, 3) in the program's axes.

    Returns:
        The mesh: z up, standing on z = 0, centred on the z axis, front towards -y. A side without
        extent is not scaled.

    Raises:
        PieceError: The file is broken, or contains no surface.
    """
    try:
        return _packed(data, np.array(metres), _Z_UP @ rotation)
    except InputError as error:
        reason = str(error).removeprefix("the mesh ")
        raise PieceError(SkipCode.BROKEN_MODEL, f"its model {reason}") from error


def _packed(data: bytes, metres: NDArray[np.float64], rotation: NDArray[np.float64]) -> PackedMesh:
    # Coordinates may overflow.
    with np.errstate(all="ignore"):
        shape = parse_obj(data)
        faces = np.empty((0, 3), np.int64) if shape.faces is None else shape.faces
        if len(faces) == 0:
            raise InputError("has no faces")
        used, renumbered = np.unique(faces, return_inverse=True)
        vertices = _scaled(shape.points_xyz[used] @ rotation.T, metres)
        mesh = TriangleMesh(vertices, renumbered.reshape(-1, 3))
        mesh.chosen_by_area(1)
        return PackedMesh.from_mesh(mesh)


def _scaled(vertices_xyz: NDArray[np.float64], metres: NDArray[np.float64]) -> NDArray[np.float64]:
    low, high = vertices_xyz.min(axis=0), vertices_xyz.max(axis=0)
    extent = high - low
    if not np.isfinite(extent).all():
        raise InputError("has coordinates that are not finite")
    # Sides without extent stay 0.
    shares = (vertices_xyz - low) / np.where(extent > 0, extent, 1)
    middle = np.where(extent > 0, metres / 2, 0) * [1, 1, 0]
    return shares * metres - middle


def _side(piece: Piece, side: str) -> float:
    text = piece.properties.get(side, "").strip()
    if not text:
        raise PieceError(SkipCode.BAD_SIZE, f"has no {side}")
    try:
        metres = float(text) / 100
    except ValueError:
        metres = math.nan
    if not 0 < metres <= MAX_SIDE_M:
        raise PieceError(SkipCode.BAD_SIZE, f"its {side} is no usable number of centimetres")
    return metres


def _is_rotation(matrix: NDArray[np.float64]) -> bool:
    return bool(
        np.allclose(matrix @ matrix.T, np.eye(3), rtol=0, atol=ROTATION_TOLERANCE)
        and np.linalg.det(matrix) > 0
    )
