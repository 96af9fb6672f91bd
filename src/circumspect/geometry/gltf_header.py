"""What a glTF file claims, looked at before it is believed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from circumspect.errors import InputError

LARGEST_HEADER = 64 << 20
"""Of the part in JSON [bytes]."""
MOST_BUFFERS = 64
MOST_VERTICES = 20_000_000
"""Of all meshes, as often as the scene shows each."""
HARMLESS_BYTES = 64 << 20
MOST_READ = 16
"""Numbers may be read several times over, but not more often."""

_SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_WIDEST = 4


def require_sound_gltf(path: Path) -> None:
    """Check what the header announces.

    Raises:
        InputError: It announces more than the file can hold, or shows a mesh without end.
    """
    try:
        header = _header(path)
        buffers = header.get("buffers", [])
        for buffer in buffers:
            _require_regular(path.parent, buffer.get("uri", "data:"))
        held = path.stat().st_size + sum(int(b.get("byteLength", 0)) for b in buffers)
        _require_few_numbers(header, held, len(buffers))
        _require_few_vertices(header)
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError,
            RecursionError) as error:  # fmt: skip
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(f"is no readable glTF file ({reason}); export it again") from error


def _header(path: Path) -> dict[str, Any]:
    with path.open("rb") as stream:
        start = stream.read(20)
        if start[:4] == b"glTF":
            size = int.from_bytes(start[12:16], "little")
        else:
            size = path.stat().st_size
            stream.seek(0)
        if size > LARGEST_HEADER:
            raise InputError(f"has a header of {size >> 20} MiB; {LARGEST_HEADER >> 20} are read")
        header = json.loads(stream.read(size))
    if not isinstance(header, dict):
        raise ValueError("its header is no object")
    return header


def _require_regular(folder: Path, uri: str) -> None:
    """Trimesh opens only what lies in the scene's folder, but opens that whatever it is."""
    for name in () if uri.startswith("data:") else (uri, Path(uri).name):
        file = folder / name
        if file.exists() and not file.is_file():
            raise InputError(f"has a buffer in {name[:80]}, which is not a regular file")


def _require_few_numbers(header: dict[str, Any], held: int, buffers: int) -> None:
    if buffers > MOST_BUFFERS:
        raise InputError(f"has {buffers} buffers; {MOST_BUFFERS} are read")
    announced = 0
    for accessor in header.get("accessors", []):
        count = int(accessor["count"])
        if count < 0:
            raise ValueError("a negative count")
        announced += count * _SIZES[accessor["type"]] * _WIDEST
    if announced > max(HARMLESS_BYTES, MOST_READ * held):
        raise InputError(f"announces {announced >> 20} MiB of numbers, holds {held >> 20} MiB")


def _require_few_vertices(header: dict[str, Any]) -> None:
    nodes = header.get("nodes", [])
    children = [child for node in nodes for child in node.get("children", [])]
    if len(set(children)) < len(children):
        raise InputError("shows a part of its scene twice; a scene is a tree")
    _require_tree(nodes)
    accessors = header.get("accessors", [])
    sizes = []
    for mesh in header.get("meshes", []):
        used = [part.get("attributes", {}).get("POSITION") for part in mesh.get("primitives", [])]
        sizes.append(sum(int(accessors[number]["count"]) for number in used if number is not None))
    shown = sum(sizes[node["mesh"]] for node in nodes if "mesh" in node)
    if shown > MOST_VERTICES:
        raise InputError(f"shows {shown} vertices; {MOST_VERTICES} are read")


def _require_tree(nodes: list[dict[str, Any]]) -> None:
    """Every node has one parent at most by now: what can not be reached from a root is a loop."""
    reached = set(range(len(nodes))) - {c for node in nodes for c in node.get("children", [])}
    waiting = list(reached)
    while waiting:
        below = nodes[waiting.pop()].get("children", [])
        reached.update(below)
        waiting += below
    if len(reached) < len(nodes):
        raise InputError("shows a part within itself; a scene is a tree")
