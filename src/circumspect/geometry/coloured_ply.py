"""Clouds in PLY with a colour and a value for each point, for other programs to show."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.ply_file import write_vertices
from circumspect.geometry.point_cloud import PointCloud


def write_coloured_ply(
    path: str | os.PathLike[str],
    cloud: PointCloud,
    colours_rgb: NDArray[np.uint8],
    value: NDArray[np.floating],
    name: str = "value",
) -> None:
    """Write points with colours and one value each as binary PLY.

    `read_cloud` reads the points back and passes over the rest.

    Args:
        path: The file; it appears when complete.
        cloud: n points [m].
        colours_rgb: (n, 3) uint8.
        value: (n,); written as float.
        name: Of the value.

    Raises:
        InputError: Colours or values that are not one each.
        OutputError: The file can not be written.
    """
    count = len(cloud)
    if colours_rgb.shape != (count, 3) or value.shape != (count,):
        raise InputError(
            f"{count} points need as many colours and values, not {colours_rgb.shape} and "
            f"{value.shape}"
        )
    places = {axis: cloud.points_xyz[:, i].astype("<f8") for i, axis in enumerate("xyz")}
    colours = {c: colours_rgb[:, i] for i, c in enumerate(("red", "green", "blue"))}
    write_vertices(path, {**places, **colours, name: value.astype("<f4")})
