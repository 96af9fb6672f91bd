"""Labelled crops: point clouds of real objects, cut out of real scenes."""

from __future__ import annotations

import hashlib
import zipfile
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.label_meaning import LabelUse, meaning_of
from circumspect.errors import InputError, printable
from circumspect.geometry import PointCloud
from circumspect.geometry.formats.npy_stream import NPZ_ERRORS, read_arrays
from circumspect.geometry.frozen_array import ReadOnlyArrays

KINDS = {"points": "f", "offsets": "iu", "label": "U", "scene": "U", "name": "U"}
"""NumPy kinds of the arrays of a file."""
OPTIONAL = ("name",)
WANTED = {
    "points": "fractions in metres; save points.astype('float32')",
    "offsets": "whole numbers; save numpy.cumsum([0, *map(len, clouds)])",
    "label": "text; save numpy.array(label, dtype=str)",
    "scene": "text; save numpy.array(scene, dtype=str)",
    "name": "text; save numpy.array(name, dtype=str)",
}
"""Error message for an array of another type."""
MAX_TEXT_LENGTH = 200
"""Maximum length of a label, scene or name [characters]."""


@dataclass(frozen=True, eq=False)
class LabelledCrops(ReadOnlyArrays):
    """Real objects, cut out of their scenes, with labels; arrays are read-only.

    Attributes:
        points_xyz: (n, 3) float [m], z up, any heading: points of all objects, concatenated.
        offsets: (k + 1,) int64; the points of object i are `offsets[i]` to `offsets[i + 1]`.
        labels: (k,) text, label of each object; not necessarily a class of a classifier.
        scenes: (k,) text, room of each object; splits are by scene.
        names: (k,) text, names of the objects in reports.

    Raises:
        InputError: The arrays do not match, or an object has no points, no label or coordinates
            that are not finite.
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
                if len(text) > MAX_TEXT_LENGTH:
                    raise InputError(
                        f"{key} of object {index} has {len(text)} characters; at most "
                        f"{MAX_TEXT_LENGTH} are read"
                    )
        blank = [index for index, label in enumerate(self.labels.tolist()) if not label.strip()]
        if blank:
            raise InputError(f"object {blank[0]} has no label; write 'unknown' if it is not known")

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
        """Description of an object in messages: number, label and scene."""
        label, scene = printable(str(self.labels[index])), printable(str(self.scenes[index]))
        return f"object {index} ({label}{' in ' * bool(scene)}{scene})"

    def cloud(self, index: int) -> PointCloud:
        """The points of one object [m]."""
        points = self.points_xyz[self.offsets[index] : self.offsets[index + 1]]
        return PointCloud(points.astype(np.float64))

    @cached_property
    def digest(self) -> str:
        """A hash of everything that determines an evaluation: points, labels, scenes and names."""
        state = hashlib.sha256()
        for texts in (self.labels, self.scenes, self.names):
            joined = "\n".join(texts.tolist()).encode(errors="surrogatepass")
            state.update(len(joined).to_bytes(8, "little") + joined)
        state.update(self.offsets.astype("<i8").tobytes())
        state.update(np.ascontiguousarray(self.points_xyz, dtype="<f8").tobytes())
        return state.hexdigest()


def is_labelled_crops(path: Path) -> bool:
    """Whether a file looks like labelled crops, complete or not: an NPZ with one of their keys.

    Point packs, which have quantised points, do not count.
    """
    if not path.is_file() or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            keys = {name.removesuffix(".npy") for name in archive.namelist()}
    except (OSError, *NPZ_ERRORS):
        return False
    return "points_u16" not in keys and not keys.isdisjoint({"offsets", "label", "scene"})


def read_labelled_crops(path: Path) -> LabelledCrops:
    """Read labelled crops from an NPZ file; keys that are not in `KINDS` are ignored.

    Raises:
        InputError: The file is missing, truncated or pickled, lacks a key, or an array has another
            type; or see `LabelledCrops`.
    """
    found = read_arrays(path, KINDS, optional=OPTIONAL, wanted=WANTED)
    try:
        labels = found["label"].astype(np.str_)
        count = len(labels) if labels.ndim == 1 else 0
        numbers = np.array([f"{index:04d}" for index in range(count)], np.str_)
        return LabelledCrops(
            _native_floats(found["points"]),
            _as_int64(found["offsets"]),
            labels,
            found["scene"].astype(np.str_),
            found["name"].astype(np.str_) if "name" in found else numbers,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _native_floats(points: NDArray[Any]) -> NDArray[np.floating]:
    """A copy in native byte order; arrays in files may be big-endian or have 16 bytes per value."""
    return points.astype(np.float64 if points.dtype.itemsize >= 8 else np.float32)


def _as_int64(offsets: NDArray[Any]) -> NDArray[np.int64]:
    largest = np.iinfo(np.int64).max
    if offsets.size and int(offsets.max()) > largest:
        raise InputError(f"offsets hold {int(offsets.max())}, more than any file has points")
    return offsets.astype(np.int64)


def read_crop_sources(paths: Sequence[Path]) -> dict[str, LabelledCrops]:
    """Read files of labelled crops.

    The name of a source is its file's, `kitchen` for `kitchen.npz`, with the folders if several
    files have the same name.

    Args:
        paths: At least one file.

    Returns:
        Objects by name of their source, in the order of `paths`.

    Raises:
        InputError: See `read_labelled_crops`; or a file is given twice, or none is given.
    """
    if not paths:
        raise InputError("no file of labelled objects is given; name one at least")
    counts = Counter(path.resolve() for path in paths)
    if twice := [path for path in paths if counts[path.resolve()] > 1]:
        raise InputError(f"{twice[0]}: is given more than once")
    return {
        name: read_labelled_crops(path)
        for name, path in zip(_short_names(paths), paths, strict=True)
    }


def require_usable_labels(files: Iterable[LabelledCrops], classes: Sequence[str]) -> None:
    """Check that at least one object has a label with a correct answer.

    Args:
        files: Labelled crops.
        classes: Classes of the classifier.

    Raises:
        InputError: All labels are ambiguous or without information.
    """
    labels = {label for crops in files for label in crops.labels.tolist()}
    if all(meaning_of(label, classes).use is LabelUse.LEFT_OUT for label in labels):
        some = ", ".join(printable(label) for label in sorted(labels)[:3])
        raise InputError(
            f"no label of the real objects says what the answer should be ({some}); "
            "docs/real-objects.md lists ambiguous labels"
        )


def _short_names(paths: Sequence[Path]) -> list[str]:
    """The shortest last parts of each path that are unique."""
    whole = [path.resolve().with_suffix("").parts for path in paths]
    depth = 1
    while len({parts[-depth:] for parts in whole}) < len(whole) and depth < max(map(len, whole)):
        depth += 1
    names = ["/".join(parts[-depth:]) for parts in whole]
    # Files that differ only in their suffix.
    return names if len(set(names)) == len(names) else [path.name for path in paths]
