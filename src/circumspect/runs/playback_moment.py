"""The state of a run at one frame, for playback."""

from __future__ import annotations

import io
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry import PinholeCamera
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.sensing.millimetres import metres, millimetres
from circumspect.storage import atomic_open

MAX_POINTS = 16_000
"""Maximum number of points of a moment; larger clouds are thinned to every n-th point."""
THUMBNAIL_WIDTH = 160
"""Approximate maximum width of images [px]."""
MAX_ARRAY_BYTES = 16 << 20
"""Maximum size of all arrays of a file [bytes]."""
MIN_STEP_M = 5e-4
"""Resolution of coordinates; coarser if the object is too large for 16 bits."""
MAX_STEPS = 32767
"""Maximum steps from the first point."""
MAX_CELLS = 1 << 21
KINDS: dict[str, str] = dict.fromkeys(
    ("frame", "origin_xyz", "step", "points", "normals", "frames_seen", "depth", "camera", "colour",
     "target", "mount", "occupied", "cells", "bounds"), "fiu",
)  # fmt: skip
"""Arrays of a file and their kinds; unknown ones are empty."""
OPTIONAL = ("step",)
"""Arrays that are missing in older files."""


@dataclass(frozen=True, eq=False)
class PlaybackMoment:
    """The state of a run at one frame.

    Attributes:
        frame: Number of the frame.
        points_xyz: (n, 3) [m] the object, map frame; n may be 0.
        normals_xyz: (n, 3) unit normals.
        frames_seen: (n,) number of frames that observed each point.
        grid: The object's grid if it is cylindrical, without free cells; else None.
        depth: (height, width) [m], thinned.
        colour: (height, width, 3) uint8 RGB, thinned; or None.
        camera: Intrinsics of the whole image.
        T_base_camera: Mount of the camera; None if unknown.
        target: (6,) the robot's next view, or None: x [m], y [m] and yaw [rad] of the base, x [m]
            and y [m] of the faced point, azimuth [rad] of the normal there, NaN if unknown.
    """

    frame: int
    points_xyz: NDArray[np.floating]
    normals_xyz: NDArray[np.floating]
    frames_seen: NDArray[np.integer]
    grid: OccupancyGrid | None
    depth: NDArray[np.floating]
    colour: NDArray[np.uint8] | None
    camera: PinholeCamera
    T_base_camera: RigidTransform | None
    target: NDArray[np.floating] | None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as npz, optimised for speed rather than size.

        Raises:
            OutputError: The file cannot be written.
        """
        with (
            atomic_open(path, "wb") as stream,
            zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        ):
            for name, array in self._arrays().items():
                packed = io.BytesIO()
                npy_format.write_array(packed, np.ascontiguousarray(array), allow_pickle=False)
                archive.writestr(f"{name}.npy", packed.getvalue())

    def _arrays(self) -> dict[str, NDArray[Any]]:
        every = -(-max(1, len(self.points_xyz)) // MAX_POINTS)
        points = self.points_xyz[::every]
        origin = points[0] if len(points) else np.zeros(3)
        offset = points - origin
        step = max(MIN_STEP_M, float(np.abs(offset).max(initial=0.0)) / MAX_STEPS)
        c = self.camera
        arrays = {
            "frame": np.array([self.frame]),
            "origin_xyz": origin,
            "step": np.array([step]),
            "points": np.rint(offset / step).astype(np.int16),
            "normals": np.rint(127 * self.normals_xyz[::every]).astype(np.int8),
            "frames_seen": np.minimum(self.frames_seen[::every], 65535).astype(np.uint16),
            "depth": millimetres(self.depth),
            "camera": np.array([c.width, c.height, c.fx, c.fy, c.cx, c.cy]),
        }
        nothing = np.empty(0)
        arrays["colour"] = np.empty(0, np.uint8) if self.colour is None else self.colour
        arrays["target"] = nothing if self.target is None else self.target
        arrays["mount"] = nothing
        if self.T_base_camera is not None:
            mount = self.T_base_camera
            arrays["mount"] = np.concatenate([mount.translation, mount.rotation.as_quat()])
        arrays |= {"occupied": np.empty(0, np.uint8), "cells": nothing, "bounds": nothing}
        if self.grid is not None and isinstance(self.grid.grid, CylindricalGrid):
            g = self.grid.grid
            arrays["occupied"] = np.packbits(self.grid.occupied)
            arrays["cells"] = np.array(g.shape)
            arrays["bounds"] = np.array(
                [g.radius, g.half_height, *g.centre_xyz, g.azimuth_offset], np.float64
            )
        return arrays

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> PlaybackMoment:
        """Read what `save` wrote.

        Raises:
            InputError: The file is missing, broken, too large, or of another kind.
        """
        arrays = read_arrays(Path(path), KINDS, MAX_ARRAY_BYTES, OPTIONAL)
        try:
            return _unpacked({name: array for name, array in arrays.items() if array.size})
        except (
            KeyError, ValueError, IndexError, TypeError, OverflowError, CircumspectError,
        ) as error:  # fmt: skip
            raise InputError(f"{path}: no moment of a run ({str(error)[:200]})") from error


def thinned(image: NDArray[Any], width: int = THUMBNAIL_WIDTH) -> NDArray[Any]:
    """Every n-th row and column of an image, so that at most about `width` columns remain."""
    every = max(1, round(image.shape[1] / width))
    return image[::every, ::every]


def _unpacked(arrays: dict[str, NDArray[Any]]) -> PlaybackMoment:
    none = np.empty((0, 3), np.int16)
    steps, normals = arrays.get("points", none), arrays.get("normals", none)
    seen = arrays.get("frames_seen", np.empty(0, np.uint16))
    if steps.ndim != 2 or steps.shape[1] != 3 or normals.shape != steps.shape:
        raise ValueError(f"points of shape {steps.shape}, normals of {normals.shape}")
    if seen.shape != (len(steps),):
        raise ValueError(f"{len(steps)} points, counts of shape {seen.shape}")
    (step,) = _finite(arrays.get("step", np.array([MIN_STEP_M])), 1)
    if not 0 < step < 1e9:
        raise ValueError(f"coordinates in steps of {step:g} m")
    depth, colour = arrays["depth"], arrays.get("colour")
    if depth.ndim != 2 or depth.dtype != np.uint16 or 0 in depth.shape:
        raise ValueError(f"depth of shape {depth.shape} and type {depth.dtype}")
    if colour is not None and (colour.shape != (*depth.shape, 3) or colour.dtype != np.uint8):
        raise ValueError(f"colour of shape {colour.shape} and type {colour.dtype}")
    width, height, *optics = _finite(arrays["camera"], 6)
    mount, target = arrays.get("mount"), arrays.get("target")
    if mount is not None:
        mount = _finite(mount, 7)
    if target is not None and (target.shape != (6,) or not np.isfinite(target[:5]).all()):
        raise ValueError("a view that is none")
    return PlaybackMoment(
        frame=int(arrays["frame"][0]),
        points_xyz=_finite(arrays["origin_xyz"], 3) + step * steps,
        normals_xyz=normals / 127.0,
        frames_seen=seen.astype(np.int64),
        grid=_grid(arrays) if "occupied" in arrays else None,
        depth=metres(depth),
        colour=colour,
        camera=PinholeCamera(int(width), int(height), *optics),
        T_base_camera=None
        if mount is None
        else RigidTransform.from_components(mount[:3], Rotation.from_quat(mount[3:])),
        target=target,
    )


def _grid(arrays: dict[str, NDArray[Any]]) -> OccupancyGrid:
    rings, sectors, layers = (int(count) for count in arrays["cells"])
    radius, half_height, x, y, z, offset = _finite(arrays["bounds"], 6)
    shape = (rings, sectors, layers)
    if min(shape) < 1 or rings * sectors * layers > MAX_CELLS:
        raise ValueError(f"a grid of {shape} cells")
    bits = np.unpackbits(arrays["occupied"].astype(np.uint8))[: rings * sectors * layers]
    grid = CylindricalGrid(shape, radius, half_height, (x, y, z), offset)
    return OccupancyGrid(grid, (2 * bits.reshape(shape)).astype(np.uint8))


def _finite(values: NDArray[Any], count: int) -> NDArray[np.float64]:
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ValueError(f"{count} finite numbers are needed, not {values.shape}")
    return values.astype(np.float64)
