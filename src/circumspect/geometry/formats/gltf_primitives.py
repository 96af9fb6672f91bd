"""The primitives of a glTF mesh: points, triangles, strips and fans."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError, MissingExtraError
from circumspect.geometry.formats.gltf_accessors import read_accessor
from circumspect.geometry.formats.gltf_document import DECODE, DRACO, MESHOPT, GltfDocument
from circumspect.geometry.formats.polygons import fan_of, strip_triangles

POINTS, TRIANGLES, STRIP, FAN = 0, 4, 5, 6
LINES = (1, 2, 3)


@dataclass(frozen=True, eq=False)
class Primitive:
    """Some vertices, and triangles over them.

    Attributes:
        points_xyz: (n, 3) float64, in the mesh's own axes.
        faces: (f, 3) indices; None for mere points.
    """

    points_xyz: NDArray[np.float64]
    faces: NDArray[np.int64] | None


@dataclass(eq=False)
class PrimitiveReader:
    """Reads primitives; shared vertices are read once."""

    document: GltfDocument
    _positions: dict[int, NDArray[np.float64]] = field(default_factory=dict)

    def read(self, part: dict[str, Any]) -> Primitive | None:
        """One primitive with the vertices that it uses; None for lines and empty ones.

        Raises:
            InputError: Broken, or of an unknown mode.
            GeometryError: Indices that name no vertex.
            MissingExtraError: Compressed with Draco, and its decoder is not installed.
        """
        mode, attributes = part.get("mode", TRIANGLES), part.get("attributes", {})
        if mode in LINES or "POSITION" not in attributes:
            return None
        if mode not in (POINTS, TRIANGLES, STRIP, FAN):
            raise InputError(f"has a primitive of the unknown mode {str(mode)[:20]}")
        compressed = part.get("extensions", {}).get(DRACO)
        if compressed is not None and not self._has_fallback(part):
            points, indices = self._decoded(compressed)
            mode = TRIANGLES if mode == STRIP else mode  # Draco holds triangles alone.
        else:
            points = self._points(attributes["POSITION"])
            indices = self._indices(part, len(points))
        if mode == POINTS:
            return Primitive(points[indices], None)
        # Only the used vertices: many primitives may share one table.
        used, compact = np.unique(indices, return_inverse=True)
        return Primitive(points[used], _triangles(mode, compact.reshape(-1)))

    def _has_fallback(self, part: dict[str, Any]) -> bool:
        """Whether a compressed primitive also has plain buffers."""
        numbers = [part["attributes"]["POSITION"], part.get("indices")]
        entries = [self.document.entry("accessors", n) for n in numbers if n is not None]
        return all("bufferView" in entry for entry in entries)

    def _points(self, index: int) -> NDArray[np.float64]:
        if index not in self._positions:
            self._require_plain(index)
            points = read_accessor(self.document, index).astype(np.float64)
            if points.shape[1:] != (3,):
                raise ValueError("positions are no VEC3")
            self._positions[index] = points
        return self._positions[index]

    def _indices(self, part: dict[str, Any], count: int) -> NDArray[np.int64]:
        if "indices" not in part:
            return np.arange(count)
        self._require_plain(part["indices"])
        values = read_accessor(self.document, part["indices"])
        if values.dtype.kind != "u" or values.shape[1:] != (1,):
            raise ValueError("indices are no unsigned integers")
        indices = values[:, 0].astype(np.int64)
        if len(indices) and indices.max() >= count:
            raise GeometryError(
                f"a face names vertex {indices.max()}, but the vertices are 0 … {count - 1}"
            )
        return indices

    def _decoded(self, compressed: dict[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        content, _ = self.document.view(compressed["bufferView"])
        points, faces = decode_draco(bytes(content), compressed["attributes"]["POSITION"])
        return points, faces.reshape(-1)

    def _require_plain(self, index: object) -> None:
        """Refuse meshopt-compressed views, which are zeros without their decoder."""
        entry = self.document.entry("accessors", index)
        if "bufferView" not in entry:
            return
        view = self.document.entry("bufferViews", entry["bufferView"])
        name = next((name for name in MESHOPT if name in view.get("extensions", {})), None)
        buffer = self.document.entry("buffers", view["buffer"])
        if name is not None and any(name in buffer.get("extensions", {}) for name in MESHOPT):
            raise InputError(f"is compressed by {name}, which is not read; {DECODE}")


def _triangles(mode: int, indices: NDArray[np.int64]) -> NDArray[np.int64]:
    if mode == STRIP:
        return strip_triangles(indices)
    if mode == FAN:
        return fan_of(indices)
    if len(indices) % 3:
        raise InputError(f"has triangles of {len(indices)} corners, which is no multiple of 3")
    return indices.reshape(-1, 3)


def decode_draco(content: bytes, position_id: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Decode a mesh.

    Args:
        content: The compressed bytes.
        position_id: Draco's unique id of the attribute that holds the positions.

    Returns:
        (n, 3) points and (f, 3) indices.

    Raises:
        InputError: Broken, or without that attribute.
        MissingExtraError: DracoPy is not installed.
    """
    try:
        import DracoPy
    except ImportError as error:
        raise MissingExtraError("DracoPy, which decodes Draco,", "formats") from error
    try:
        mesh = DracoPy.decode(content)
        attribute = mesh.get_attribute_by_unique_id(position_id)
        faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
    except MemoryError:
        raise
    except Exception as error:  # Whatever the decoder raises for broken data.
        raise InputError(f"has broken Draco data ({str(error)[:80]}); export it again") from error
    points = None if attribute is None else np.asarray(attribute["data"], np.float64)
    if points is None or points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"has Draco data without positions (attribute {position_id})")
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(points):
        raise InputError("has Draco data with faces that name no vertex")
    return points, faces
