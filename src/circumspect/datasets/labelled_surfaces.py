"""Objects that simulated scans are made of: labelled surfaces with a size."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh

OTHER = "other"
"""Label of what is of none of the classes."""
HELD_BACK = 6
"""Of catalogues without near duplicates one object in so many is held back."""


class MeshSource(Protocol):
    """Makes the surfaces of a set, one at a time."""

    def mesh(self, index: int) -> TriangleMesh:
        """The surface of one object [m], z up, standing on z = 0."""
        ...


@dataclass(frozen=True, eq=False)
class LabelledSurfaces:
    """Objects of known class with sizes in metres.

    Attributes:
        source: Makes their surfaces.
        indices: (n,) which of the source's objects they are.
        labels: (n,) text, the class of each; "other" for what is of no class.
        names: (n,) text.
        digest: A hash of all that determines the surfaces.
        factors: (n, 2) by how much each may shrink and grow, for objects whose unit is unknown;
            None where sizes are known.
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
        """By how much an object may shrink and grow; 1 and 1 where its size is known."""
        if self.factors is None:
            return 1.0, 1.0
        low, high = self.factors[index]
        return float(low), float(high)

    def subset(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> LabelledSurfaces:
        """The objects that a mask or an index array names, in its order."""
        names = self.names[chosen]
        return LabelledSurfaces(
            self.source, self.indices[chosen], self.labels[chosen], names,
            digest_of([self.digest, *names.tolist()]),
            None if self.factors is None else self.factors[chosen],
        )  # fmt: skip

    def held_back(self, salt: str = "") -> NDArray[np.bool_]:
        """(n,) one object in `HELD_BACK`, chosen by a hash of its name."""
        return np.array([found % HELD_BACK == 0 for found in self.hashes(salt)], bool)

    def hashes(self, salt: str = "") -> list[int]:
        """A hash of the name of each object."""
        return [
            int.from_bytes(hashlib.sha256((salt + name).encode(errors="surrogatepass")).digest())
            for name in self.names.tolist()
        ]


def digest_of(parts: Sequence[str]) -> str:
    """A hash of texts."""
    return hashlib.sha256("\n".join(parts).encode(errors="surrogatepass")).hexdigest()
