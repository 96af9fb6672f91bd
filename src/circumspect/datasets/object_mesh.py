"""A mesh file of a set as an object's surface."""

from __future__ import annotations

from pathlib import Path

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import TriangleMesh, read_mesh

SUFFIXES = (".off", ".OFF")
"""Of the files that are meshes of a set."""


def read_object_mesh(file: Path) -> TriangleMesh:
    """Read a mesh on which points can be drawn.

    Raises:
        InputError: It can not be read, or has no area; the message names the file.
    """
    mesh = read_mesh(file)
    try:
        mesh.chosen_by_area(1)
    except GeometryError as error:
        raise InputError(f"{file}: {error}") from error
    return mesh
