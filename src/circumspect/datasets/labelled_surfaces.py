"""Labelled surfaces with a size, for simulated scans."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh

OTHER = "other"
"""Label of objects that belong to no class."""
HELD_BACK = 6
"""One in this many objects of a catalogue without near duplicates is held back."""


class MeshSource(Protocol):
    """Source of the surfaces of a set, one at a time."""

    def mesh(self, index: int) -> TriangleMesh:
        """The surface of one object [m], z up, standing on z = 0."""
        ...


@dataclass(frozen=True, eq=False)
class LabelledSurfaces:
    """Objects of known class with sizes in metres.

    Attributes:
        source: Source of the surfaces.
        indices: (n,) indices of the objects in the source.
        labels: (n,) text, class of each object; "other" for objects of no class.
        names: (n,) text, names of the objects.
        digest: Hash of everything that defines the surfaces.
        factors: (n, 2) smallest and largest scale of each object of unknown unit; None if all sizes
            are known.
    """

    source: MeshSource
    indices: NDArray[np.int64]
    labels: NDArray[np.str_]
    names: NDArray[np.str_]
    digest: str
    factors: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self.indices)

    def mesh(self, index: int) -> TriangleMesh:
        """The surface of one object [m]."""
        return self.source.mesh(int(self.indices[index]))

    def size_factors(self, index: int) -> tuple[float, float]:
        """Smallest and largest scale of an object; 1 and 1 if its size is known."""
        if self.factors is None:
            return 1.0, 1.0
        low, high = self.factors[index]
        return float(low), float(high)

    def subset(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> LabelledSurfaces:
        """The objects of a mask or an index array, in its order."""
        names = self.names[chosen]
        return LabelledSurfaces(
            self.source, self.indices[chosen], self.labels[chosen], names,
            digest_of([self.digest, *names.tolist()]),
            None if self.factors is None else self.factors[chosen],
        )  # fmt: skip

    def held_back(self, salt: str = "") -> NDArray[np.bool_]:
        """(n,) whether each object is held back, by a hash of its name."""
        return np.array([found % HELD_BACK == 0 for found in self.hashes(salt)], bool)

    def hashes(self, salt: str = "") -> list[int]:
        """Hashes of the objects' names."""
        return [
            int.from_bytes(hashlib.sha256((salt + name).encode(errors="surrogatepass")).digest())
            for name in self.names.tolist()
        ]


def digest_of(parts: Sequence[str]) -> str:
    """Hash of texts."""
    return hashlib.sha256("\n".join(parts).encode(errors="surrogatepass")).hexdigest()
