"""Point packs: one npz file per split, with quantised points of all objects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.storage import atomic_open

KINDS = {"points_u16": "iu", "offset": "f", "scale": "f", "labels": "iu", "names": "U",
         "classes": "U", "metric": "b"}  # fmt: skip
"""NumPy kinds of the arrays of a pack."""
OPTIONAL = ("metric",)
"""Key that states whether scales are in metres; packs of earlier versions lack it."""
WANTED = {
    "points_u16": "uint16; scale the coordinates to 0 … 65535 and save them as that",
    "labels": "whole numbers; they count the classes from 0: save labels.astype('int16')",
    "offset": "fractions; save offset.astype('float64')",
    "scale": "fractions; save scale.astype('float64')",
    "names": "text; save numpy.array(names, dtype=str)",
    "classes": "text; save numpy.array(classes, dtype=str)",
}
"""Error message for an array of another type."""


def read_point_pack(path: Path) -> ObjectSet:
    """Read a pack.

    Coordinates are `points_u16 / 65535 * scale + offset`. The set has them in units of each
    object's longest side, since the scale is arbitrary per object; `sides` are these lengths.

    Raises:
        InputError: The file is missing, broken or lacks a key, an array has another type, or an
            object spans no shape.
    """
    pack = read_arrays(path, KINDS, optional=OPTIONAL, wanted=WANTED)
    points, labels = pack["points_u16"], pack["labels"]
    names, classes = pack["names"], pack["classes"]
    if points.dtype != np.uint16:
        raise InputError(
            f"{path}: points_u16 holds an array of {points.dtype}, not of {WANTED['points_u16']}"
        )
    if points.ndim != 3:
        raise InputError(f"{path}: points_u16 must have shape (n, p, 3), not {points.shape}")
    if classes.ndim != 1:
        raise InputError(f"{path}: classes must have shape (c,), not {classes.shape}")
    try:
        objects = ObjectSet(
            (points / np.float32(65535)).astype(np.float32),
            labels.astype(np.int64),
            names.astype(np.str_),
            tuple(str(name) for name in classes),
            sides=pack["scale"].astype(np.float64),
            metric=pack.get("metric"),
        )
        objects.require_shapes()
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return objects


def write_point_pack(path: Path, objects: ObjectSet) -> None:
    """Write a pack; each object is quantised to 1/65535 of its longest side.

    Raises:
        OutputError: The file cannot be written.
    """
    low = objects.points_xyz.min(axis=1).astype(np.float64)
    scale = np.maximum((objects.points_xyz.max(axis=1) - low).max(axis=1), np.finfo(float).tiny)
    unit = (objects.points_xyz - low[:, None]) / scale[:, None, None]
    if objects.sides is not None:
        low, scale = low * (objects.sides / scale)[:, None], objects.sides
    # Objects without a unit have no such key, as in earlier versions.
    metric: dict[str, Any] = {} if objects.metric is None else {"metric": objects.metric}
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream,
            **metric,
            points_u16=np.rint(unit * 65535).astype(np.uint16),
            offset=low,
            scale=scale,
            labels=objects.labels.astype(np.int16),
            names=objects.names,
            classes=np.array(objects.classes),
        )
