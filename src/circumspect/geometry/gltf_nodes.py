"""The nodes of a glTF scene: which meshes stand where."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.gltf_accessors import read_accessor
from circumspect.geometry.gltf_document import GltfDocument, whole
from circumspect.geometry.gltf_extensions import INSTANCING, VISIBILITY

MAX_VERTICES = 20_000_000
"""Of all meshes, as often as the scene shows each."""
MAX_INSTANCES = 10_000
"""Of one mesh in one node."""


@dataclass(frozen=True, eq=False)
class ShownMesh:
    """A mesh at its places.

    Attributes:
        mesh: Its entry in the header.
        matrices: (m, 4, 4) homogeneous transforms from the mesh into the scene, one an instance.
    """

    mesh: dict[str, Any]
    matrices: NDArray[np.float64]


def shown_meshes(document: GltfDocument) -> list[ShownMesh]:
    """The meshes of the scene, each with its transforms.

    The default scene counts, else the first one. Without scenes all nodes count, without nodes all
    meshes.

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
    """From the roots of the scene down; no node is met twice."""
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
    """(m, 4, 4) from each instance of a mesh into its node; one at the node itself as a rule."""
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
    """How many vertices of a mesh can be used at most."""
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
