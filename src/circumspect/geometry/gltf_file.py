"""glTF 2.0 and GLB: scenes of meshes, each at its place; y up and in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.gltf_accessors import require_plausible_accessors
from circumspect.geometry.gltf_document import GltfDocument
from circumspect.geometry.gltf_extensions import require_known_extensions
from circumspect.geometry.gltf_nodes import shown_meshes
from circumspect.geometry.gltf_primitives import Primitive, PrimitiveReader

UP = "y"
"""The specification fixes it."""

_BROKEN = (
    ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError, RecursionError,
)  # fmt: skip
"""What entries of the wrong type and values out of range raise."""


def read_gltf(path: Path) -> FileShape:
    """Read all meshes of the scene as one, or all its points where it has no meshes.

    Materials, cameras, skins, animations and lines are passed over: a posed or animated object is
    read as its nodes place it.

    Raises:
        InputError: Not glTF 2.0, broken, or with a required extension that is not honoured.
        GeometryError: Faces that name vertices which do not exist.
        MissingExtraError: It needs a decoder that is not installed.
    """
    try:
        document = GltfDocument.load(path)
        require_known_extensions(document)
        require_plausible_accessors(document, path.stat().st_size + document.held_bytes())
        parts = _parts(document)
    except CircumspectError:
        raise
    except _BROKEN as error:
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no readable glTF file ({reason}); export it again") from error
    meshes = [part for part in parts if part.faces is not None and len(part.faces)]
    chosen = meshes or [part for part in parts if part.faces is None]
    if not chosen:
        raise InputError("has neither faces nor points in its scene")
    points = np.concatenate([part.points_xyz for part in chosen])
    if not meshes:
        return FileShape(points, up=UP)
    firsts = np.cumsum([0, *(len(part.points_xyz) for part in chosen[:-1])])
    faces = [
        part.faces + first
        for part, first in zip(chosen, firsts, strict=True)
        if part.faces is not None
    ]
    return FileShape(points, np.concatenate(faces), up=UP)


def _parts(document: GltfDocument) -> list[Primitive]:
    """All primitives of the scene, in its coordinates."""
    reader, parts = PrimitiveReader(document), []
    for shown in shown_meshes(document):
        for entry in shown.mesh.get("primitives", []):
            primitive = reader.read(entry)
            if primitive is not None:
                parts += [_placed(primitive, matrix) for matrix in shown.matrices]
    return parts


def _placed(primitive: Primitive, matrix: NDArray[np.float64]) -> Primitive:
    points = primitive.points_xyz @ matrix[:3, :3].T + matrix[:3, 3]
    return Primitive(points, primitive.faces)
