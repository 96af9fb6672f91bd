"""Labelled real objects: the point clouds of objects that were cut out of real scenes."""

from __future__ import annotations

import hashlib
import zipfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, printable
from circumspect.geometry import PointCloud
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.geometry.npy_stream import NPZ_FAULTS, read_arrays

KINDS = {"points": "f", "offsets": "iu", "label": "U", "scene": "U", "name": "U"}
"""Arrays of a file to NumPy's letters for what they hold."""
OPTIONAL = ("name",)
WANTED = {
    "points": "fractions in metres; save points.astype('float32')",
    "offsets": "whole numbers; save numpy.cumsum([0, *map(len, clouds)])",
    "label": "text; save numpy.array(label, dtype=str)",
    "scene": "text; save numpy.array(scene, dtype=str)",
    "name": "text; save numpy.array(name, dtype=str)",
}
"""What is said of an array that holds something else."""
LONGEST_TEXT = 200
"""Of a label, a scene or a name."""


@dataclass(frozen=True, eq=False)
class LabelledCrops(ReadOnlyArrays):
    """Real objects, cut out of their scenes, with labels; arrays are read-only.

    Attributes:
        points_xyz: (n, 3) float [m], z up, any heading: the points of all objects, one object after
            the other.
        offsets: (k + 1,) int64: the points of object i are `offsets[i]` to `offsets[i + 1]`.
        labels: (k,) text: what each object is; not necessarily a class of a classifier.
        scenes: (k,) text: the room in which each object stands; a split into parts is by scene.
        names: (k,) text: what tells objects apart in reports.

    Raises:
        InputError: The arrays do not belong together, or an object has no points, no label or
            coordinates that are not finite.
    """

    points_xyz: NDArray[np.floating]
    offsets: NDArray[np.int64]
    labels: NDArray[np.str_]
    scenes: NDArray[np.str_]
    names: NDArray[np.str_]

    def __post_init__(self) -> None:
        points, count = self.points_xyz, len(self.labels) if self.labels.ndim == 1 else None
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"points must have shape (n, 3), not {points.shape}")
        if count is None:
            raise InputError(f"label must have shape (k,), not {self.labels.shape}")
        if not count:
            raise InputError("label is empty; a file holds one object at least")
        for key, texts in (("scene", self.scenes), ("name", self.names)):
            if texts.shape != (count,):
                raise InputError(f"{count} labels need as many of {key}, not {texts.shape}")
        if self.offsets.shape != (count + 1,):
            raise InputError(
                f"{count} labels need {count + 1} offsets, the last one being the number of "
                f"points, not {self.offsets.shape}"
            )
        self._check_offsets()
        self._check_texts()
        self._check_coordinates()
        for array in vars(self).values():
            array.flags.writeable = False

    def _check_offsets(self) -> None:
        offsets, count = self.offsets, len(self.points_xyz)
        if offsets[0] != 0 or offsets[-1] != count:
            raise InputError(
                f"offsets must go from 0 to {count}, the number of points, not from "
                f"{offsets[0]} to {offsets[-1]}"
            )
        steps = np.diff(offsets)
        if (steps < 0).any():
            first = int(np.flatnonzero(steps < 0)[0])
            raise InputError(
                f"offsets must ascend; offset {first + 1} is {offsets[first + 1]}, "
                f"less than {offsets[first]} before it"
            )
        if (steps == 0).any():
            raise InputError(f"{self.title(int(np.flatnonzero(steps == 0)[0]))} has no points")

    def _check_texts(self) -> None:
        for key, texts in (("label", self.labels), ("scene", self.scenes), ("name", self.names)):
            for index, text in enumerate(texts.tolist()):
                if len(text) > LONGEST_TEXT:
                    raise InputError(
                        f"{key} of object {index} has {len(text)} characters; at most "
                        f"{LONGEST_TEXT} are read"
                    )
        blank = [index for index, label in enumerate(self.labels.tolist()) if not label.strip()]
        if blank:
            raise InputError(
                f"object {blank[0]} has no label; write 'unknown' where nobody knows what it is"
            )

    def _check_coordinates(self) -> None:
        bad = np.flatnonzero(~np.isfinite(self.points_xyz).all(axis=1))
        if len(bad):
            of = np.searchsorted(self.offsets, bad, side="right") - 1
            index, count = int(of[0]), int((of == of[0]).sum())
            raise InputError(
                f"{self.title(index)} has {count} points that are NaN or infinite; remove them"
            )

    def __len__(self) -> int:
        return len(self.labels)

    def title(self, index: int) -> str:
        """An object in a message: its number, label and scene."""
        label, scene = printable(str(self.labels[index])), printable(str(self.scenes[index]))
        return f"object {index} ({label}{' in ' * bool(scene)}{scene})"

    def cloud(self, index: int) -> PointCloud:
        """The points of one object [m]."""
        points = self.points_xyz[self.offsets[index] : self.offsets[index + 1]]
        return PointCloud(points.astype(np.float64))

    @cached_property
    def digest(self) -> str:
        """A hash of all that determines an evaluation: points, labels, scenes and names."""
        state = hashlib.sha256()
        for texts in (self.labels, self.scenes, self.names):
            joined = "\n".join(texts.tolist()).encode(errors="surrogatepass")
            state.update(len(joined).to_bytes(8, "little") + joined)
        state.update(self.offsets.astype("<i8").tobytes())
        state.update(np.ascontiguousarray(self.points_xyz, dtype="<f8").tobytes())
        return state.hexdigest()


def is_labelled_crops(path: Path) -> bool:
    """Whether a file looks like labelled crops, complete or not: an NPZ with one of their keys.

    Point packs, whose points are quantised, are no such files.
    """
    if not path.is_file() or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            keys = {name.removesuffix(".npy") for name in archive.namelist()}
    except (OSError, *NPZ_FAULTS):
        return False
    return "points_u16" not in keys and not keys.isdisjoint({"offsets", "label", "scene"})


def read_labelled_crops(path: Path) -> LabelledCrops:
    """Read labelled crops from an NPZ file; keys beside those of `KINDS` are ignored.

    Raises:
        InputError: The file is missing, truncated or pickled, lacks a key, one holds another type
            of values, or see `LabelledCrops`.
    """
    found = read_arrays(path, KINDS, optional=OPTIONAL, wanted=WANTED)
    try:
        labels = found["label"].astype(np.str_)
        count = len(labels) if labels.ndim == 1 else 0
        numbers = np.array([f"{index:04d}" for index in range(count)], np.str_)
        return LabelledCrops(
            _of_double_precision_at_most(found["points"]),
            _whole_numbers(found["offsets"]),
            labels,
            found["scene"].astype(np.str_),
            found["name"].astype(np.str_) if "name" in found else numbers,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _of_double_precision_at_most(points: NDArray[Any]) -> NDArray[np.floating]:
    """A copy in the machine's byte order: what was read may be big-endian or of 16 bytes."""
    return points.astype(np.float64 if points.dtype.itemsize >= 8 else np.float32)


def _whole_numbers(offsets: NDArray[Any]) -> NDArray[np.int64]:
    largest = np.iinfo(np.int64).max
    if offsets.size and int(offsets.max()) > largest:
        raise InputError(f"offsets hold {int(offsets.max())}, more than any file has points")
    return offsets.astype(np.int64)
