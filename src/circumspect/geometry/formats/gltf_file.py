"""glTF 2.0 and GLB: scenes of placed meshes; y up and in metres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.gltf_accessors import read_accessor, require_plausible_accessors
from circumspect.geometry.formats.gltf_document import (
    INSTANCING,
    VISIBILITY,
    GltfDocument,
    require_known_extensions,
    whole,
)
from circumspect.geometry.formats.gltf_primitives import Primitive, PrimitiveReader

UP = "y"
"""The up axis of the specification."""
_BROKEN = (
    ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError, RecursionError,
)  # fmt: skip
"""Exceptions for entries of wrong types and values out of range."""
MAX_VERTICES = 20_000_000
"""Largest number of vertices of all meshes, counted per instance."""
MAX_INSTANCES = 10_000
"""Largest number of instances of one mesh in one node."""


@dataclass(frozen=True, eq=False)
class ShownMesh:
    """A mesh and its transforms.

    Attributes:
        mesh: Its entry in the header.
        matrices: (m, 4, 4) homogeneous transforms from the mesh into the scene, one per instance.
    """

    mesh: dict[str, Any]
    matrices: NDArray[np.float64]


def shown_meshes(document: GltfDocument) -> list[ShownMesh]:
    """The meshes of the scene, each with its transforms.

    The default scene is used, else the first one. Without scenes all nodes are used, without nodes
    all meshes.

    Raises:
        InputError: A scene that is no tree, or one with too many vertices.
    """
    if not document.entries("nodes"):
        shown = [ShownMesh(mesh, np.eye(4)[None]) for mesh in document.entries("meshes")]
    else:
        shown = list(_walked(document))
    count = sum(len(one.matrices) * _vertices(document, one.mesh) for one in shown)
    if count > MAX_VERTICES:
        raise InputError(f"shows {count} vertices; {MAX_VERTICES} are read")
    return shown


def _walked(document: GltfDocument) -> Iterator[ShownMesh]:
    """Traverse the scene from its roots; each node occurs once."""
    waiting = [(root, np.eye(4)) for root in _roots(document)]
    met: set[int] = set()
    while waiting:
        index, matrix = waiting.pop()
        node = document.entry("nodes", index)
        if index in met:
            raise InputError(f"shows node {index} twice or within itself; a scene is a tree")
        met.add(index)
        extensions = node.get("extensions", {})
        if not extensions.get(VISIBILITY, {}).get("visible", True):
            continue
        matrix = matrix @ _local(node)
        waiting += [(child, matrix) for child in node.get("children", [])]
        if "mesh" in node:
            instances = _instances(document, extensions.get(INSTANCING))
            yield ShownMesh(document.entry("meshes", node["mesh"]), matrix @ instances)


def _roots(document: GltfDocument) -> list[int]:
    if document.entries("scenes"):
        return document.entry("scenes", document.header.get("scene", 0)).get("nodes", [])
    nodes = document.entries("nodes")
    children = [child for node in nodes for child in node.get("children", [])]
    for child in children:
        document.entry("nodes", child)
    roots = set(range(len(nodes))) - set(children)
    if not roots:
        raise InputError("shows its nodes within each other; a scene is a tree")
    return sorted(roots)


def _local(node: dict[str, Any]) -> NDArray[np.float64]:
    """(4, 4) from a node into its parent."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    return _composed(
        _numbers(node.get("translation", [0, 0, 0]), 3)[None],
        _numbers(node.get("rotation", [0, 0, 0, 1]), 4)[None],
        _numbers(node.get("scale", [1, 1, 1]), 3)[None],
    )[0]


def _instances(document: GltfDocument, extension: dict[str, Any] | None) -> NDArray[np.float64]:
    """(m, 4, 4) from each instance of a mesh into its node; usually one at the node itself."""
    if extension is None:
        return np.eye(4)[None]
    defaults = {"TRANSLATION": [0, 0, 0], "ROTATION": [0, 0, 0, 1], "SCALE": [1, 1, 1]}
    indices = {name: i for name, i in extension["attributes"].items() if name in defaults}
    counts = {whole(document.entry("accessors", i)["count"], "count") for i in indices.values()}
    count = max(counts, default=0)
    if count > MAX_INSTANCES:
        raise InputError(f"shows {count} instances of a mesh; {MAX_INSTANCES} are read")
    parts = {
        name: np.asarray(read_accessor(document, i), np.float64) for name, i in indices.items()
    }
    columns = [parts.get(k, np.tile(np.array(v, float), (count, 1))) for k, v in defaults.items()]
    if [part.shape for part in columns] != [(count, 3), (count, 4), (count, 3)]:
        raise ValueError("attributes of instances differ in number")
    return _composed(*columns)


def _composed(
    translations: NDArray[np.float64], quaternions: NDArray[np.float64], scales: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(m, 4, 4) matrices of (m, 3) translations, (m, 4) quaternions xyzw and (m, 3) scales."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if not (lengths > 0).all():
        raise ValueError("a rotation of length zero")
    x, y, z, w = (quaternions / lengths).T
    rotations = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    matrices = np.tile(np.eye(4), (len(scales), 1, 1))
    matrices[:, :3, :3] = rotations * scales[:, None, :]
    matrices[:, :3, 3] = translations
    return matrices


def _numbers(values: object, count: int) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.shape != (count,):
        raise ValueError(f"{count} numbers are needed in a transform, not {array.shape}")
    return array


def _vertices(document: GltfDocument, mesh: dict[str, Any]) -> int:
    """Upper bound of the used vertices of a mesh."""
    total = 0
    for part in mesh.get("primitives", []):
        places = part.get("attributes", {}).get("POSITION")
        if places is None:
            continue
        count = whole(document.entry("accessors", places)["count"], "count")
        if "indices" in part:
            named = whole(document.entry("accessors", part["indices"])["count"], "count")
            count = min(count, named)
        total += count
    return total


def read_gltf(path: Path) -> FileShape:
    """Read all meshes of the scene as one, or all its points where it has no meshes.

    Materials, cameras, skins, animations and lines are ignored: a posed or animated object is read
    as its nodes place it.

    Raises:
        InputError: Not glTF 2.0, broken, or with an unsupported required extension.
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
