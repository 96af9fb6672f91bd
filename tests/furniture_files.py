"""Mesh files of procedural furniture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from circumspect.furniture import make_furniture
from circumspect.geometry import TriangleMesh


def write_obj(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Path:
    """Write an OBJ file."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines))
    return path


def write_off(path: Path, mesh: TriangleMesh) -> None:
    """Write an OFF file."""
    lines = ["OFF", f"{len(mesh.vertices_xyz)} {len(mesh.faces)} 0"]
    lines += [f"{x} {y} {z}" for x, y, z in mesh.vertices_xyz]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces]
    path.write_text("\n".join(lines))


def write_lying_chair(path: Path) -> Path:
    """Write an OBJ file of a chair in centimetres with y up, away from the origin."""
    mesh = make_furniture("chair", 3)
    lying = 100 * mesh.vertices_xyz[:, [0, 2, 1]] * [1, 1, -1] + [30.0, 7.0, -4.0]
    return write_obj(path, lying, mesh.faces)
