"""Arrays of numbers in a glTF file: strided, sparse, and normalised integers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.formats.gltf_document import GltfDocument, whole

UNCHECKED_BYTES = 64 << 20
MAX_READ_RATIO = 16
"""Largest ratio of the numbers' size to the files' size, since views may be shared."""

_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_MAX_COMPONENT_BYTES = 4


def require_plausible_accessors(document: GltfDocument, held_bytes: int) -> None:
    """Check that the arrays together are not far larger than the files that hold them.

    An accessor without a buffer view is all zeros, and several may share one view.

    Args:
        document: The file.
        held_bytes: Size of the file and of its buffers.

    Raises:
        InputError: They are far larger.
        ValueError: A negative count.
    """
    announced = sum(
        whole(one["count"], "count") * _WIDTHS[one["type"]] * _MAX_COMPONENT_BYTES
        for one in document.entries("accessors")
    )
    if announced > max(UNCHECKED_BYTES, MAX_READ_RATIO * held_bytes):
        raise InputError(
            f"announces {announced >> 20} MiB of numbers, holds {held_bytes >> 20} MiB"
        )


def read_accessor(document: GltfDocument, index: object) -> NDArray[Any]:
    """The values of an accessor.

    Args:
        document: The file.
        index: Of the accessor.

    Returns:
        (count, width) in the type of the file; float64 where integers are normalised.

    Raises:
        InputError: It reaches beyond its buffer, or a sparse index beyond its count.
    """
    entry = document.entry("accessors", index)
    count, width = whole(entry["count"], "count"), _WIDTHS[entry["type"]]
    kind = np.dtype(_COMPONENTS[entry["componentType"]])
    if "bufferView" in entry:
        values = _strided(document, entry, kind, count, width)
    else:
        values = np.zeros((count, width), kind)
    if "sparse" in entry:
        values = _with_sparse(document, entry["sparse"], values)
    return _normalised(values) if entry.get("normalized") and kind.kind in "iu" else values


def _strided(
    document: GltfDocument, entry: dict[str, Any], kind: np.dtype, count: int, width: int
) -> NDArray[Any]:
    content, stride = document.view(entry["bufferView"])
    start = whole(entry.get("byteOffset", 0), "byteOffset")
    row = width * kind.itemsize
    stride = stride or row
    needed = start + (count - 1) * stride + row if count else 0
    if needed > len(content) or stride < row:
        raise InputError(
            f"ends too early: {count} values need {needed} bytes of their buffer view, "
            f"{len(content)} found"
        )
    if count == 0:
        return np.empty((0, width), kind)
    return np.ndarray((count, width), kind, content, start, (stride, kind.itemsize))


def _with_sparse(
    document: GltfDocument, sparse: dict[str, Any], values: NDArray[Any]
) -> NDArray[Any]:
    """A copy with some rows replaced."""
    count, places = whole(sparse["count"], "count"), sparse["indices"]
    kind = np.dtype(_COMPONENTS[places["componentType"]])
    if kind.kind != "u":
        raise ValueError("indices of a sparse accessor are no unsigned integers")
    rows = _strided(document, places, kind, count, 1)[:, 0]
    if count and int(rows.max()) >= len(values):
        raise InputError(f"replaces value {int(rows.max())} of {len(values)}")
    replaced = values.copy()
    replaced[rows] = _strided(document, sparse["values"], values.dtype, count, values.shape[1])
    return replaced


def _normalised(values: NDArray[Any]) -> NDArray[np.float64]:
    """Integers as fractions of their largest value; signed ones lie in -1 … 1."""
    return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
