"""Mesh readers compared with trimesh's: `python -m benchmarks.readers`.

Prints the peak memory while a mesh is read from each format, and the area that each reader returns
for variants of glTF that the specification allows.
"""

from __future__ import annotations

import argparse
import base64
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.evaluation.markdown import table

FORMATS = ("off", "ply", "stl", "obj", "glb")
OURS = "from circumspect.geometry import read_mesh; area = lambda p: read_mesh(p).areas.sum()"
TRIMESH = (
    "import trimesh; trimesh.util.log.disabled = True\n"
    "def area(path): return trimesh.load_scene(path, process=False).to_mesh().area"
)
PEAK = (
    "import pathlib, re\nfrom sys import argv\n{reader}\n{warm}\n"
    "def peak():\n"
    "    status = pathlib.Path('/proc/self/status').read_text()\n"
    "    return int(re.search(r'VmHWM:\\s*(\\d+) kB', status)[1])\n"
    "before = peak(); area(argv[1]); print(peak() - before)"
)
AREA = "from sys import argv\n{reader}\nprint(area(argv[1]))"
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=400, help="vertices along a side of the mesh")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        print(memory_table(Path(name), given.side))
        print()
        print(variant_table(Path(name)))
    return 0


def memory_table(folder: Path, side: int) -> str:
    """Peak of memory above that of the libraries, in multiples of the file's size."""
    import trimesh

    mesh, rows = wavy_mesh(side), []
    warm = folder / "warm.stl"
    trimesh.creation.box().export(str(warm))
    for kind in FORMATS:
        path = folder / f"mesh.{kind}"
        mesh.export(str(path))
        size = path.stat().st_size
        peaks = [
            1024 * float(child(PEAK.format(reader=reader, warm=f"area({str(warm)!r})"), path))
            for reader in (OURS, TRIMESH)
        ]
        rows.append(
            [kind.upper(), f"{size / 1e6:.0f} MB", *(f"{peak / size:.1f}" for peak in peaks)]
        )
    return table(["format", "file", "ours: peak / file", "trimesh: peak / file"], rows)


def variant_table(folder: Path) -> str:
    """The area of a unit square, or of two, in several forms of glTF."""
    rows = []
    for name, header in variants(folder).items():
        path = folder / "a.gltf"
        path.write_text(json.dumps(header))
        found = [child(AREA.format(reader=reader), path) for reader in (OURS, TRIMESH)]
        rows.append([name, "2" if name == "two instances" else "1", *map(area_text, found)])
    return table(["variant", "area", "ours", "trimesh"], rows)


def variants(folder: Path) -> dict[str, dict[str, Any]]:
    """Headers by name; all buffers are embedded except for one in a file."""
    (folder / "my square.bin").write_bytes(SQUARE.tobytes())
    triangles, fan = np.array([0, 1, 2, 0, 2, 3], np.uint32), np.arange(4, dtype=np.uint32)
    shares = np.rint(SQUARE * 65535).astype(np.uint16)
    places = np.array([[0, 0, 0], [9, 0, 0]], np.float32)
    plain = square(SQUARE, triangles)
    sparse = square(np.zeros_like(SQUARE), triangles, fan, SQUARE)
    sparse["accessors"][0]["sparse"] = {
        "count": 4,
        "indices": {"bufferView": 2, "componentType": 5125},
        "values": {"bufferView": 3},
    }
    quantised = square(shares, triangles)
    quantised["accessors"][0] |= {"componentType": 5123, "normalized": True}
    quantised["extensionsRequired"] = ["KHR_mesh_quantization"]
    fans = square(SQUARE, fan)
    fans["accessors"][1]["count"] = 4
    fans["meshes"][0]["primitives"][0]["mode"] = 6
    instances = square(SQUARE, triangles, places)
    instances["accessors"].append(
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}
    )
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}
    instances["nodes"][0]["extensions"] = extension
    instances["extensionsRequired"] = list(extension)
    escaped = square(SQUARE, triangles)
    escaped["buffers"][0] = {"byteLength": 48, "uri": "my%20square.bin"}
    return {
        "plain": plain, "sparse accessor": sparse, "normalised integers": quantised,
        "triangle fan": fans, "two instances": instances, "escaped URI": escaped,
    }  # fmt: skip


def square(*arrays: np.ndarray) -> dict[str, Any]:
    """The header of a file with positions, indices, and more arrays, each in its own buffer."""
    contents = [array.tobytes() for array in arrays]
    return {
        "asset": {"version": "2.0"},
        "buffers": [
            {
                "byteLength": len(one),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(one).decode(),
            }
            for one in contents
        ],
        "bufferViews": [
            {"buffer": number, "byteLength": len(one)} for number, one in enumerate(contents)
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }


def wavy_mesh(side: int) -> Any:
    """A surface of 2 (side - 1)² triangles."""
    import trimesh

    x, y = np.meshgrid(*[np.linspace(0, 1, side)] * 2)
    points = np.stack([x, y, 0.1 * np.sin(9 * x)], axis=-1).reshape(-1, 3)
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (
        corner[rows, columns].reshape(-1)
        for rows in (slice(None, -1), slice(1, None))
        for columns in (slice(None, -1), slice(1, None))
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    return trimesh.Trimesh(points, faces, process=False)


def child(program: str, path: Path) -> str:
    """Output of a program for a file, in a process of its own; empty if it fails."""
    words = [sys.executable, "-c", program, str(path)]
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()


def area_text(area: str) -> str:
    """An area, or "fails"."""
    return f"{float(area):.4g}" if area else "fails"


if __name__ == "__main__":
    sys.exit(main())
