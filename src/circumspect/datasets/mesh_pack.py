"""Mesh packs: one npz file of labelled meshes with real sizes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.mesh_set import AMBIGUOUS, OTHER, MeshEntry, MeshObject, MeshSet
from circumspect.errors import InputError
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.storage import atomic_open

__all__ = [
    "AMBIGUOUS",
    "OTHER",
    "MeshEntry",
    "MeshObject",
    "MeshSet",
    "read_mesh_pack",
    "write_mesh_pack",
]

TEXTS = ("name", "category", "catalogue", "licence", "creator", "mid")
"""Arrays with one text per mesh, in the order of `MeshSet`."""
KINDS = {
    "verts_u16": "u", "offset": "f", "scale": "f", "faces": "iu", "voff": "iu", "foff": "iu",
    **dict.fromkeys(TEXTS, "U"),
    "dims": "f", "class10": "i", "furniture_size": "b", "classes": "U",
}  # fmt: skip
"""NumPy kinds of the arrays of a pack."""
WANTED = {
    "verts_u16": "uint16; scale the coordinates to 0 … 65535 and save them as that",
    "class10": "signed whole numbers (-1 other, -2 ambiguous)",
    "furniture_size": "truth values (bool)",
}


def read_mesh_pack(path: Path) -> MeshSet:
    """Read a pack; the meshes stay packed.

    Raises:
        InputError: The file is missing, broken or truncated, lacks a key, or its arrays have a
            wrong type, do not match or refer to vertices that do not exist.
    """
    pack = read_arrays(path, KINDS, wanted=WANTED)
    try:
        if pack["verts_u16"].dtype != np.uint16:
            raise InputError(f"verts_u16 must be uint16, not {pack['verts_u16'].dtype}")
        if pack["classes"].ndim != 1:
            raise InputError(f"classes must have shape (c,), not {pack['classes'].shape}")
        return MeshSet(
            pack["verts_u16"], pack["faces"],
            pack["voff"].astype(np.int64), pack["foff"].astype(np.int64),
            pack["offset"], pack["scale"],
            pack["class10"], pack["dims"], pack["furniture_size"],
            *(pack[key] for key in TEXTS),
            classes=tuple(str(name) for name in pack["classes"]),
        )  # fmt: skip
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def write_mesh_pack(path: Path, entries: Sequence[MeshEntry], classes: Sequence[str]) -> None:
    """Write a pack.

    Args:
        path: The file, an npz.
        entries: The meshes with their records, at least one.
        classes: Class names in the order of the labels.

    Raises:
        InputError: There are no entries, or a label has no class.
        OutputError: The file cannot be written.
    """
    if not entries:
        raise InputError(f"{path}: a mesh pack holds at least one mesh; none were given")
    most = max(len(entry.packed.vertices_u16) for entry in entries)
    index = np.uint16 if most <= 1 << 16 else np.uint32

    def column(of: Callable[[MeshEntry], Any], dtype: Any) -> NDArray[Any]:
        return np.array([of(entry) for entry in entries], dtype)

    packed = [entry.packed for entry in entries]
    arrays = MeshSet(
        np.concatenate([mesh.vertices_u16 for mesh in packed]),
        np.concatenate([mesh.faces.astype(index) for mesh in packed]),
        _starts([len(mesh.vertices_u16) for mesh in packed]),
        _starts([len(mesh.faces) for mesh in packed]),
        column(lambda entry: entry.packed.offset, np.float64),
        column(lambda entry: entry.packed.scale, np.float64),
        column(lambda entry: entry.label, np.int16),
        column(lambda entry: entry.metres, np.float32),
        column(lambda entry: entry.furniture_size, np.bool_),
        column(lambda entry: entry.title, np.str_),
        column(lambda entry: entry.category, np.str_),
        column(lambda entry: entry.catalogue, np.str_),
        column(lambda entry: entry.licence, np.str_),
        column(lambda entry: entry.creator, np.str_),
        column(lambda entry: entry.model_id, np.str_),
        classes=tuple(classes),
    )
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream,
            verts_u16=arrays.vertices_u16, faces=arrays.faces,
            voff=arrays.vertex_starts, foff=arrays.face_starts,
            offset=arrays.offset, scale=arrays.scale,
            class10=arrays.labels, dims=arrays.metres, furniture_size=arrays.furniture_size,
            **dict(zip(TEXTS, arrays.texts, strict=True)),
            classes=np.array(arrays.classes),
        )  # fmt: skip


def _starts(counts: list[int]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
