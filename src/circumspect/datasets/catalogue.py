"""Catalogues of meshes with real sizes, for simulated scans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circumspect.datasets.labelled_surfaces import LabelledSurfaces, digest_of
from circumspect.datasets.mesh_pack import read_mesh_pack
from circumspect.datasets.mesh_set import MeshObject
from circumspect.errors import InputError
from circumspect.geometry import TriangleMesh


@dataclass(frozen=True, eq=False)
class CatalogueSurfaces:
    """The meshes of a pack.

    Attributes:
        objects: See `MeshObject`.
    """

    objects: tuple[MeshObject, ...]

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        return self.objects[index].mesh


def read_catalogue(path: Path) -> LabelledSurfaces:
    """Read a pack of meshes: the objects of its classes, and those of other kinds.

    Raises:
        InputError: The file is missing or broken, or contains no training object.
    """
    pack = read_mesh_pack(path)
    objects = (*pack.labelled, *pack.others)
    if not objects:
        raise InputError(f"{path}: holds no object of a class and no furniture of another kind")
    names = [f"{path.stem}/{one.name}" for one in objects]
    sizes = [str(one.packed.scale) for one in objects]
    return LabelledSurfaces(
        CatalogueSurfaces(objects), np.arange(len(objects)),
        np.array([one.label for one in objects], np.str_), np.array(names, np.str_),
        digest_of(["meshes 1", *names, *sizes]),
    )  # fmt: skip
