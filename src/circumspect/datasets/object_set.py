"""Labelled point clouds."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import GeometryError, InputError
from circumspect.geometry import PointCloud, require_extent


@dataclass(frozen=True, eq=False)
class ObjectSet:
    """Labelled objects with one cloud each.

    Attributes:
        points_xyz: (n, p, 3) float32, p points on the surface of each object, z up, any unit.
        labels: (n,) int64 indices into `classes`.
        names: (n,) unique names, such as chair_0001.
        classes: The class names, in alphabetical order.
        scan_of: (n,) name of the scanned object of each cloud, if clouds can share an object; else
            None.
        sides: (n,) longest side of each object in the unit of its file, before normalisation; None
            if unknown.
        metric: (n,) bool, whether each side is in metres; None if no unit is known.

    Raises:
        InputError: The arrays do not match.
    """

    points_xyz: NDArray[np.float32]
    labels: NDArray[np.int64]
    names: NDArray[np.str_]
    classes: tuple[str, ...]
    scan_of: NDArray[np.str_] | None = None
    sides: NDArray[np.float64] | None = None
    metric: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        count = len(self.points_xyz)
        if self.points_xyz.ndim != 3 or self.points_xyz.shape[2] != 3:
            raise InputError(f"points must have shape (n, p, 3), not {self.points_xyz.shape}")
        if self.labels.shape != (count,) or self.names.shape != (count,):
            raise InputError(
                f"{count} objects need as many labels and names, not "
                f"{self.labels.shape} and {self.names.shape}"
            )
        if self.scan_of is not None and self.scan_of.shape != (count,):
            raise InputError(f"{count} scans need as many objects, not {self.scan_of.shape}")
        if self.sides is not None and self.sides.shape != (count,):
            raise InputError(f"{count} objects need as many sides, not {self.sides.shape}")
        if self.metric is not None and (self.sides is None or self.metric.shape != (count,)):
            raise InputError(f"{count} objects need as many sides and units of them")
        if count and not 0 <= self.labels.min() <= self.labels.max() < len(self.classes):
            raise InputError(f"labels lie outside the {len(self.classes)} classes")
        if not np.isfinite(self.points_xyz).all():
            raise InputError("the set holds NaN or infinite coordinates")

    def __len__(self) -> int:
        return len(self.points_xyz)

    def cloud(self, index: int) -> PointCloud:
        """The points of one object."""
        return PointCloud(self.points_xyz[index])

    def require_shapes(self) -> None:
        """Check that every object spans a shape.

        Raises:
            InputError: An object does not; the message names it.
        """
        for index, name in enumerate(self.names):
            try:
                require_extent(self.cloud(index))
            except GeometryError as error:
                raise InputError(f"{name}: {error}") from error

    def subset(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> ObjectSet:
        """The objects of a mask or an index array."""
        return ObjectSet(
            self.points_xyz[chosen],
            self.labels[chosen],
            self.names[chosen],
            self.classes,
            None if self.scan_of is None else self.scan_of[chosen],
            None if self.sides is None else self.sides[chosen],
            None if self.metric is None else self.metric[chosen],
        )

    @property
    def shown(self) -> NDArray[np.str_]:
        """(n,) name of the object in each cloud; clouds of one object share it."""
        return self.names if self.scan_of is None else self.scan_of

    @cached_property
    def digest(self) -> str:
        """Hash of the set: names, labels, classes and coordinates."""
        words = "\n".join([*self.classes, "", *self.names.tolist()])
        # Names of files need not be valid text; surrogates are hashed as characters.
        state = hashlib.sha256(words.encode(errors="surrogatepass"))
        state.update(self.labels.astype("<i8").tobytes())
        state.update(np.ascontiguousarray(self.points_xyz, dtype="<f4").tobytes())
        return state.hexdigest()
