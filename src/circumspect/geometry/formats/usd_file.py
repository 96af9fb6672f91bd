"""USD, USDA, USDC and USDZ of phones and animation programs, by usd-core (extra `usd`)."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import CircumspectError, InputError, MissingExtraError
from circumspect.geometry.formats.file_shape import FileShape
from circumspect.geometry.formats.library_reading import require_readable_count
from circumspect.geometry.formats.polygons import fan_triangles_mixed

if TYPE_CHECKING:
    from collections.abc import Iterator

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
MAX_LAYERS = 200

Part = tuple[NDArray[np.float64], NDArray[np.int64] | None]
"""Points [m], and triangles over them; None for a cloud."""


def read_usd(path: Path) -> FileShape:
    """Read all visible meshes of the default time as one, or all points where there are none.

    The up axis and the unit are those that the file states; coordinates are returned in metres.
    Subdivision surfaces are read as their control meshes.

    Raises:
        InputError: Not a USD file, broken, or it refers to files outside of its folder.
        MissingExtraError: usd-core is not installed.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError("is a USD file by its content, which needs a name that ends in .usdc")
    # The library writes errors to standard error unless they are collected.
    delegate, UsdGeom = _pxr("UsdUtils").CoalescingDiagnosticDelegate(), _pxr("UsdGeom")
    try:
        stage = _opened(path)
        unit_m = float(UsdGeom.GetStageMetersPerUnit(stage))
        up = str(UsdGeom.GetStageUpAxis(stage)).lower()
        parts = list(_parts(stage, unit_m))
    except (CircumspectError, MemoryError):
        raise
    except Exception as error:  # The library lets through what broken files bring about.
        # The message begins with a line of the library's own code.
        reason = str(error).strip().partition("\n")[0].rpartition(" : '")[2]
        raise InputError(f"is no readable USD file ({reason[:200]}); export it again") from error
    finally:
        del delegate
    return _joined(parts, up)


def _pxr(module: str) -> Any:
    """A module of usd-core, which has no types."""
    try:
        return importlib.import_module(f"pxr.{module}")
    except ImportError as error:
        raise MissingExtraError("usd-core, which reads USD,", "usd") from error


def _opened(path: Path) -> Any:
    layer = _pxr("Sdf").Layer.FindOrOpen(str(path.resolve()))
    if layer is None:
        raise InputError("is no readable USD file; export it again")
    _require_local(layer, path.resolve().parent)
    return _pxr("Usd").Stage.Open(layer)


def _require_local(layer: Any, folder: Path) -> None:
    """Refuse untrusted layers that refer to files outside of the folder."""
    waiting, met = [layer], set()
    while waiting:
        one = waiting.pop()
        if one.identifier in met:
            continue
        met.add(one.identifier)
        if len(met) > MAX_LAYERS:
            raise InputError(f"refers to more than {MAX_LAYERS} other layers")
        for asset in one.GetCompositionAssetDependencies():
            if not asset:
                continue
            place = one.ComputeAbsolutePath(asset)
            file = Path(place.partition("[")[0])
            if not file.resolve().is_relative_to(folder) or (file.exists() and not file.is_file()):
                raise InputError(f"refers to {asset[:80]}, outside of its folder")
            if (nested := _pxr("Sdf").Layer.FindOrOpen(place)) is not None:
                waiting.append(nested)


def _parts(stage: Any, unit_m: float) -> Iterator[Part]:
    """All visible meshes and points, in the coordinates of the stage [m]."""
    Usd, UsdGeom = _pxr("Usd"), _pxr("UsdGeom")
    places, count = UsdGeom.XformCache(), 0
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        mesh, cloud = UsdGeom.Mesh(prim), UsdGeom.Points(prim)
        if not mesh and not cloud:
            continue
        imageable = UsdGeom.Imageable(prim)
        hidden = imageable.ComputeVisibility() == UsdGeom.Tokens.invisible
        if hidden or imageable.ComputePurpose() not in ("default", "render"):
            continue
        points = np.array((mesh or cloud).GetPointsAttr().Get() or [], np.float64).reshape(-1, 3)
        count += len(points)
        require_readable_count(count)
        # Rows are multiplied from the left in USD.
        matrix = np.array(places.GetLocalToWorldTransform(prim))
        placed = unit_m * (points @ matrix[:3, :3] + matrix[3, :3])
        yield placed, _faces(mesh, len(points)) if mesh else None


def _faces(mesh: Any, vertex_count: int) -> NDArray[np.int64]:
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get() or [], np.int64)
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get() or [], np.int64)
    if (counts < 0).any() or counts.sum() != len(indices):
        raise InputError(f"has faces of {counts.sum()} corners in all, but {len(indices)} indices")
    return fan_triangles_mixed(np.split(indices, np.cumsum(counts)[:-1]), vertex_count)


def _joined(parts: list[Part], up: str) -> FileShape:
    meshes = [(points, faces) for points, faces in parts if faces is not None and len(faces)]
    if meshes:
        firsts = np.cumsum([0, *(len(points) for points, _ in meshes[:-1])])
        faces = [faces + first for (_, faces), first in zip(meshes, firsts, strict=True)]
        points = np.concatenate([points for points, _ in meshes])
        return FileShape(points, np.concatenate(faces), up=up)
    clouds = [points for points, faces in parts if faces is None]
    if not clouds:
        raise InputError("has neither faces nor points in its scene")
    return FileShape(np.concatenate(clouds), up=up)
