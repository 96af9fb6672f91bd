"""A reader of another package, held to what the readers here keep."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.errors import InputError
from circumspect.geometry.file_shape import FileShape
from circumspect.geometry.point_cloud import PointCloud
from circumspect.geometry.triangle_mesh import TriangleMesh
from circumspect.plugins import cause_of, kind_of


class PluginReader:
    """Calls a foreign reader; whatever it raises becomes an `InputError`."""

    def __init__(self, name: str, read: Callable[[Path], Any]) -> None:
        """Keep it.

        Args:
            name: As it was asked for.
            read: From a path to a `PointCloud`, a `TriangleMesh`, or an (n, 3) array of points.
        """
        self._name, self._read = name, read

    def __call__(self, path: Path) -> FileShape:
        """What the file holds.

        Raises:
            InputError: The reader fails, or returns something else.
        """
        try:
            return _shape(self._read(path))
        except InputError as error:
            raise type(error)(f"reader '{self._name}': {error}") from error
        except OSError:
            raise
        # Foreign code may raise anything on a broken file.
        except Exception as error:
            raise InputError(f"reader '{self._name}' fails: {cause_of(error)}") from error


def checked_reader(name: str, value: Any) -> PluginReader:
    """What a plug-in offers, if it can be called.

    Raises:
        InputError: It can not.
    """
    if not callable(value):
        raise InputError(f"{kind_of(value)}; a function of a path is needed")
    return PluginReader(name, value)


def _shape(read: Any) -> FileShape:
    if isinstance(read, TriangleMesh):
        return FileShape(np.array(read.vertices_xyz, np.float64), np.array(read.faces, np.int64))
    if isinstance(read, np.ndarray):
        read = PointCloud(read)
    if isinstance(read, PointCloud):
        normals = None if read.normals_xyz is None else np.array(read.normals_xyz, np.float64)
        areas = None if read.areas is None else np.array(read.areas, np.float64)
        return FileShape(np.array(read.points_xyz, np.float64), None, normals, areas)
    raise InputError(f"what it returns {kind_of(read)}; a PointCloud or a TriangleMesh is needed")
