"""glTF and GLB, by trimesh: scenes of meshes, each at its place."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.gltf_header import require_sound_gltf
from circumspect.geometry.ignored_warnings import ignored_warnings


def read_gltf(path: Path) -> FileShape:
    """Read all meshes of the scene as one, or all its points where it has no meshes.

    Raises:
        InputError: trimesh can not read it.
    """
    import trimesh

    require_sound_gltf(path)
    with _quiet():
        try:
            # Materials are pictures, which could unpack to anything and are of no use here.
            scene = trimesh.load_scene(path, process=False, skip_materials=True)
            parts = scene.dump()
        except (MemoryError, OSError):
            raise
        except Exception as error:  # trimesh lets through whatever broken files bring about.
            reason = str(error).partition("\n")[0] or type(error).__name__
            raise InputError(f"is no readable glTF file ({reason}); export it again") from error
    meshes = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if meshes:
        firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
        return FileShape(
            np.concatenate([np.asarray(mesh.vertices, dtype=np.float64) for mesh in meshes]),
            np.concatenate(
                [
                    np.asarray(mesh.faces) + first
                    for mesh, first in zip(meshes, firsts, strict=False)
                ]
            ),
        )
    clouds = [part for part in parts if isinstance(part, trimesh.PointCloud)]
    if not clouds:
        raise InputError("has neither faces nor points in its scene")
    return FileShape(np.concatenate([np.asarray(cloud.vertices) for cloud in clouds]))


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what trimesh warns, logs and prints from the user; what fails is raised anyway.

    Standard streams belong to the whole process, too: they are redirected while this thread alone
    is let in.
    """
    log = logging.getLogger("trimesh")
    with (
        ignored_warnings(),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        disabled, log.disabled = log.disabled, True
        try:
            yield
        finally:
            log.disabled = disabled
