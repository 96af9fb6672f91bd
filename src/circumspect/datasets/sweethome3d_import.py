"""Sweet Home 3D's furniture catalogues as a mesh pack."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from circumspect.datasets.mesh_pack import AMBIGUOUS, OTHER, MeshEntry
from circumspect.datasets.sweethome3d_catalogue import (
    Catalogue,
    Models,
    Piece,
    PieceError,
    SkipCode,
    catalogue_files,
    open_models,
    read_catalogue,
)
from circumspect.datasets.sweethome3d_classes import CLASSES, has_furniture_size, label_of
from circumspect.datasets.sweethome3d_models import placed_model, rotation_of, size_of
from circumspect.errors import InputError
from circumspect.geometry.npy_stream import MOST_BYTES

LARGEST_PACK = MOST_BYTES // 2
"""Vertices and faces of all models [bytes]: a reader takes twice as much."""


@dataclass(frozen=True)
class Skipped:
    """A piece that was left out.

    Attributes:
        catalogue: Name of its catalogue.
        number: Of its keys in the properties.
        title: What the catalogue calls it.
        code: Why.
        reason: The same for a human.
    """

    catalogue: str
    number: int
    title: str
    code: SkipCode
    reason: str


@dataclass
class ImportedCatalogues:
    """What catalogues gave.

    Attributes:
        entries: The models that were read.
        skipped: The pieces that were left out.
        licences: Name and licence of a catalogue to how many models it gave.
    """

    entries: list[MeshEntry] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)
    licences: Counter[tuple[str, str]] = field(default_factory=Counter)

    def to_dict(self) -> dict[str, Any]:
        """JSON types."""
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

    A model that can not be used is left out and recorded; so is one that is the same, of the same
    size, as an earlier one.

    Args:
        path: A .sh3f file, or a folder; see `catalogue_files`.
        progress: Called with (done, all) after each piece.

    Raises:
        InputError: A catalogue can not be read, or no model of all can.
    """
    # All properties are read first, so that a broken catalogue is found before the long work.
    catalogues = [read_catalogue(file) for file in catalogue_files(path)]
    total = sum(len(catalogue.pieces) for catalogue in catalogues)
    imported = ImportedCatalogues()
    seen: set[bytes] = set()
    size = 0
    for catalogue in catalogues:
        with open_models(catalogue.path) as models:
            for piece in catalogue.pieces:
                size += _take(imported, catalogue, models, piece, seen)
                if size > LARGEST_PACK:
                    raise InputError(
                        f"{path}: its models take more than {LARGEST_PACK >> 20} MiB; import "
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
    models: Models,
    piece: Piece,
    seen: set[bytes],
) -> int:
    """Add a piece to the entries or to those left out; the bytes that it takes."""
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


def _entry(catalogue: Catalogue, models: Models, piece: Piece, seen: set[bytes]) -> MeshEntry:
    """A piece's model with its record.

    Raises:
        PieceError: It can not be used.
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
