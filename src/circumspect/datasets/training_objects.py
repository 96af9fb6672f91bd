"""Objects that simulated scans are made of: labelled surfaces with a size."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import TriangleMesh


class MeshSource(Protocol):
    """Makes the surfaces of a set, one at a time."""

    def mesh(self, index: int) -> TriangleMesh:
        """The surface of one object [m], z up, standing on z = 0."""


@dataclass(frozen=True, eq=False)
class TrainingObjects:
    """Objects of known class with sizes in metres.

    Attributes:
        source: Makes their surfaces.
        indices: (n,) which of the source's objects they are.
        labels: (n,) text, the class of each; "other" for what is of no class.
        names: (n,) text.
        digest: A hash of all that determines the surfaces.
    """

    source: MeshSource
    indices: NDArray[np.int64]
    labels: NDArray[np.str_]
    names: NDArray[np.str_]
    digest: str

    def __len__(self) -> int:
        return len(self.indices)

    def mesh(self, index: int) -> TriangleMesh:
        """The surface of one object [m]."""
        return self.source.mesh(int(self.indices[index]))


def digest_of(parts: Sequence[str]) -> str:
    """A hash of texts."""
    return hashlib.sha256("\n".join(parts).encode(errors="surrogatepass")).hexdigest()
