"""The object that `scan` puts into its room: furniture, a mesh file, or one of a data set."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from circumspect.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from circumspect.geometry import TriangleMesh


@dataclass(frozen=True, eq=False)
class ScannedObject:
    """An object on the floor of a room.

    Attributes:
        name: A name that selects the same object again.
        label: Its class; None where unknown.
        mesh: Its surface [m], standing on z = 0, the middle of its box on the z axis.
    """

    name: str
    label: str | None
    mesh: TriangleMesh


def scanned_object(
    words: str,
    variant: int,
    up: str | None = None,
    height: float | None = None,
    data: Path | None = None,
) -> ScannedObject:
    """Find or make the requested object.

    Args:
        words: A category of furniture, one with a variant ("chair-17"), a mesh file, or with
            `data` the name of an object there.
        variant: Variant of the furniture, unless `words` names one.
        up: The axis that points up in a mesh file; None means the convention of its format.
        height: Height to which a mesh file is scaled [m]; None means that its unit is a metre.
        data: ModelNet10's folder of point packs, or that of OFF files.

    Raises:
        InputError: There is no such object, or a flag does not go with it.
    """
    from circumspect.furniture import CATEGORIES, make_furniture

    turned = height is not None or up is not None
    if data is not None:
        if turned:
            raise InputError(f"--up and --height are for mesh files, not for objects of {data}")
        return _from_points(words, data)
    named = re.fullmatch(r"([a-z_]+)(?:-(\d+))?", words)
    if named is not None and named[1] in CATEGORIES:
        if turned:
            raise InputError(f"--up and --height are for mesh files, not for {words!r}")
        number = variant if named[2] is None else int(named[2])
        return ScannedObject(f"{named[1]}-{number}", named[1], make_furniture(named[1], number))
    if Path(words).is_file():
        return _from_file(Path(words), up, height)
    if Path(words).is_dir():
        raise InputError(f"{words}: is a folder; give a mesh file")
    if Path(words).suffix or Path(words).name != words:
        raise InputError(f"{words}: no such file")
    hint = "; --data says where ModelNet10 is" if re.search(r"_\d+$", words) else ""
    near = difflib.get_close_matches(words.partition("-")[0], CATEGORIES, 1)
    meant = f"did you mean {near[0]}? " if near else ""
    raise InputError(
        f"no object {words!r}; {meant}give a mesh file or one of: {', '.join(CATEGORIES)}{hint}"
    )


def _from_file(file: Path, up: str | None, height: float | None) -> ScannedObject:
    from circumspect.errors import naming_file
    from circumspect.geometry import read_mesh

    if height is not None and not 0 < height <= 10:
        raise InputError(f"--height {height}: give metres, above 0 and at most 10")
    with naming_file(file):
        return ScannedObject(str(file), None, _standing(read_mesh(file, up=up), height))


def _standing(mesh: TriangleMesh, height: float | None) -> TriangleMesh:
    """Place the mesh on z = 0, the middle of its box on the z axis, at the given height."""
    from circumspect.errors import GeometryError
    from circumspect.geometry import TriangleMesh

    low, high = mesh.vertices_xyz.min(axis=0), mesh.vertices_xyz.max(axis=0)
    if not high[2] > low[2]:
        raise GeometryError("is flat: it has no height; is another axis --up?")
    scale = 1.0 if height is None else height / float(high[2] - low[2])
    foot = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]
    return TriangleMesh((mesh.vertices_xyz - foot) * scale, mesh.faces)


def _from_points(name: str, data: Path) -> ScannedObject:
    """An object of ModelNet10 from its points, in metres by the typical size of its class."""
    from circumspect.errors import naming_file
    from circumspect.simulation import surface_from_points

    packs = sorted(data.glob("*.npz")) if data.is_dir() else [data]
    found = _in_packs(name, packs) if packs else _in_off_folder(name, data)
    if found is None:
        raise InputError(f"{data}: no object {name!r} there; names are like chair_0890")
    label, points, side = found
    with naming_file(data / name):
        return ScannedObject(name, label, surface_from_points(points, label, side))


def _in_packs(name: str, packs: list[Path]) -> tuple[str, NDArray[np.float32], float | None] | None:
    """Class and points of an object, and its longest side [m] or None."""
    from circumspect.datasets.point_pack import read_point_pack

    for pack in packs:
        objects = read_point_pack(pack)
        for index in (objects.names == name).nonzero()[0]:
            label = objects.classes[int(objects.labels[index])]
            known = (
                objects.metric is not None and objects.sides is not None and objects.metric[index]
            )
            side = float(objects.sides[index]) if known and objects.sides is not None else None
            return label, objects.points_xyz[index], side
    return None


def _in_off_folder(name: str, data: Path) -> tuple[str, NDArray[np.float32], float | None] | None:
    """The same from its mesh alone, since sampling all of them takes minutes."""
    from circumspect.datasets.object_mesh import sample_object
    from circumspect.datasets.off_folder import object_files, object_name

    files = sorted(file for split in ("train", "test") for file in object_files(data, split))
    if not files:
        raise InputError(
            f"{data}: no point packs there (test.npz, train.npz), nor <class>/{{train,test}}/*.off"
        )
    for file in files:
        if object_name(file) == name:
            sample = sample_object(file)
            side = sample.side if sample.metric else None
            return file.parent.parent.name, sample.points_xyz, side
    return None
