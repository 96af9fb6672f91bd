"""A glTF 2.0 file: its JSON header and the bytes of its buffers."""

from __future__ import annotations

import base64
import binascii
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

from circumspect.errors import InputError
from circumspect.geometry.formats.file_errors import MAX_FILE_BYTES

MAX_HEADER_BYTES = 64 << 20
"""Largest size of the JSON part."""
MAX_BUFFERS = 64
_GLB_HEADER = 12
_JSON_CHUNK, _BINARY_CHUNK = b"JSON", b"BIN\0"
DRACO = "KHR_draco_mesh_compression"
INSTANCING = "EXT_mesh_gpu_instancing"
VISIBILITY = "KHR_node_visibility"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression", "MESHOPT_compression")
_HONOURED = {"KHR_mesh_quantization", DRACO, INSTANCING, VISIBILITY}
# They affect colours, pictures, lights, cameras, animations or remarks, but no surface.
_WITHOUT_GEOMETRY = (
    "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_xmp", "KHR_animation_", "KHR_audio",
    "KHR_techniques_webgl", "EXT_texture_", "EXT_lights_", "EXT_materials_", "EXT_mesh_features",
    "EXT_structural_metadata", "MSFT_texture_", "MSFT_packing_", "ADOBE_materials_", "AGI_",
    "CESIUM_primitive_outline", "FB_materials_", "GOOGLE_texture_", "NV_materials_", "VRM", "MPEG_",
)  # fmt: skip
DECODE = "decode it: gltf-transform copy IN.glb OUT.glb"
"""Remedy for compressed geometry."""


@dataclass(frozen=True, eq=False)
class GltfDocument:
    """Header and buffers; entries are looked up by checked indices.

    Attributes:
        header: The parsed JSON.
        folder: Where files named by relative URIs lie.
        binary: The binary chunk of a GLB file; None without one.
    """

    header: dict[str, Any]
    folder: Path
    binary: bytes | None = None
    _buffers: dict[int, bytes] = field(default_factory=dict, repr=False)

    @classmethod
    def load(cls, path: Path) -> GltfDocument:
        """Read the header, and the binary chunk of a GLB file.

        Raises:
            InputError: Not glTF 2.0, truncated, or a header that is too large.
            ValueError: Not JSON.
        """
        with path.open("rb") as stream:
            start = stream.read(_GLB_HEADER)
            if start[:4] != b"glTF":
                size = path.stat().st_size
                stream.seek(0)
                _require_small(size)
                return cls(_parsed(stream.read(size)), path.parent)
            if (version := int.from_bytes(start[4:8], "little")) != 2:
                raise _old_version(f"{version}.0")
            header, binary = None, None
            while header is None or binary is None:
                chunk = stream.read(8)
                if len(chunk) < 8:
                    break
                size, kind = int.from_bytes(chunk[:4], "little"), chunk[4:]
                if kind == _JSON_CHUNK and header is None:
                    _require_small(size)
                    header = _parsed(stream.read(size))
                elif kind == _BINARY_CHUNK and binary is None:
                    binary = stream.read(min(size, path.stat().st_size))
                else:
                    stream.seek(size, 1)
        if header is None:
            raise InputError("ends too early: a GLB file without its header")
        return cls(header, path.parent, binary)

    def entries(self, name: str) -> list[dict[str, Any]]:
        """A list of the header; empty where it is missing.

        Raises:
            ValueError: Not a list of objects.
        """
        found = self.header.get(name, [])
        if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
            raise ValueError(f"{name} is no list of objects")
        return found

    def entry(self, name: str, index: object) -> dict[str, Any]:
        """One entry of a list of the header.

        Raises:
            InputError: The list has no such entry; negative indices are none either.
        """
        found = self.entries(name)
        if type(index) is not int or not 0 <= index < len(found):
            raise InputError(f"names entry {str(index)[:20]} of {name}, which has {len(found)}")
        return found[index]

    def view(self, index: object) -> tuple[memoryview, int]:
        """The bytes of a buffer view, and its stride; 0 means tightly packed.

        Raises:
            InputError: It reaches beyond its buffer.
        """
        view = self.entry("bufferViews", index)
        content = self._buffer(view["buffer"])
        start = whole(view.get("byteOffset", 0), "byteOffset")
        length = whole(view["byteLength"], "byteLength")
        if start + length > len(content):
            raise InputError(
                f"ends too early: buffer view {index} needs {start + length} bytes of its buffer, "
                f"{len(content)} found"
            )
        stride = whole(view.get("byteStride", 0), "byteStride")
        return memoryview(content)[start : start + length], stride

    def held_bytes(self) -> int:
        """Size of the buffers in other files [bytes].

        Raises:
            InputError: A file is missing, not regular, or outside of the folder; or there are more
                bytes than are read of one object.
        """
        held = 0
        for entry in self.entries("buffers"):
            uri, length = entry.get("uri", "data:"), whole(entry["byteLength"], "byteLength")
            if not uri.startswith("data:"):
                held += min(length, self._file(uri).stat().st_size)
        if held > MAX_FILE_BYTES:
            raise InputError(f"needs {held >> 30} GiB of buffers; {MAX_FILE_BYTES >> 30} are read")
        return held

    def _buffer(self, index: object) -> bytes:
        entry, number = self.entry("buffers", index), whole(index, "buffer")
        if number not in self._buffers:
            self._buffers[number] = self._content(entry)
        return self._buffers[number]

    def _content(self, entry: dict[str, Any]) -> bytes:
        uri, length = entry.get("uri"), whole(entry["byteLength"], "byteLength")
        if uri is None:
            if self.binary is None:
                raise InputError("has a buffer without data: neither a URI nor a binary chunk")
            return self.binary[:length]
        if uri.startswith("data:"):
            return _data_uri(uri)[:length]
        file = self._file(uri)
        with file.open("rb") as stream:
            return stream.read(min(length, file.stat().st_size))

    def _file(self, uri: str) -> Path:
        """The file of a relative URI, within the folder of the scene."""
        # Some exporters do not escape, so a literal % is tried as well.
        names = [unquote(uri), uri]
        for name in names:
            file = Path(self.folder, name)
            parts = Path(name).parts
            if ":" in name.partition("/")[0] or Path(name).is_absolute() or ".." in parts:
                raise InputError(f"has a buffer in {uri[:80]}, outside of its folder")
            if file.exists():
                if not file.is_file():
                    raise InputError(f"has a buffer in {uri[:80]}, which is not a regular file")
                return file
        raise InputError(f"needs {names[0][:80]}, which does not lie beside it")


def whole(value: object, name: str) -> int:
    """A count, size or offset of the header.

    Raises:
        ValueError: Not a whole number of at least 0.
    """
    if type(value) is not int or value < 0:
        raise ValueError(f"{name} is {str(value)[:20]}, negative or no whole number")
    return value


def _parsed(content: bytes) -> dict[str, Any]:
    header = json.loads(content)
    if not isinstance(header, dict):
        raise ValueError("its header is no object")
    asset = header.get("asset")
    version = str(asset.get("version", "2.0") if isinstance(asset, dict) else "2.0")
    if version.partition(".")[0] != "2":
        raise _old_version(version[:20])
    if len(header.get("buffers", [])) > MAX_BUFFERS:
        raise InputError(f"has {len(header['buffers'])} buffers; {MAX_BUFFERS} are read")
    return header


def _old_version(version: str) -> InputError:
    return InputError(
        f"is glTF {version}, and only glTF 2.0 is read; convert it: gltf-pipeline -i OLD -o NEW"
    )


def _require_small(size: int) -> None:
    if size > MAX_HEADER_BYTES:
        raise InputError(f"has a header of {size >> 20} MiB; {MAX_HEADER_BYTES >> 20} are read")


def _data_uri(uri: str) -> bytes:
    kind, _, content = uri.partition(",")
    if not kind.endswith(";base64"):
        return unquote_to_bytes(content)
    try:
        return base64.b64decode(content, validate=True)
    except binascii.Error as error:
        raise ValueError(f"a buffer in base64 is broken: {error}") from error


def require_known_extensions(document: GltfDocument) -> None:
    """Check that every required extension is supported.

    Raises:
        InputError: It requires another one; the message names it.
    """
    required = document.header.get("extensionsRequired", [])
    if not isinstance(required, list) or not all(isinstance(name, str) for name in required):
        raise ValueError("extensionsRequired is no list of names")
    for name in required:
        if name in MESHOPT:
            raise InputError(f"is compressed by {name}, which is not read; {DECODE}")
        if name not in _HONOURED and not name.startswith(_WITHOUT_GEOMETRY):
            raise InputError(
                f"requires the extension {name[:60]}, which is not read; export it without"
            )
