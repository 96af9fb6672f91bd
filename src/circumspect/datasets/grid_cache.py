"""Cache of the grids of whole sets, as packed bits under a key of everything that defines them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.cache_folder import cache_folder
from circumspect.storage import atomic_open

FORMAT = 2


class GridCache:
    """A folder of arrays of packed bits.

    Args:
        folder: Folder of the cache; None means the user's cache folder.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = cache_folder("grids") if folder is None else folder

    def get(
        self,
        key: dict[str, Any],
        count: int,
        shape: tuple[int, ...],
        make: Callable[[], Iterable[NDArray[np.uint8]]],
    ) -> PackedGrids:
        """The grids of a key, created if missing.

        Args:
            key: Everything that defines the grids, as JSON types.
            count: Number of grids.
            shape: Shape of one grid, including leading axes such as views.
            make: Yields the grids one by one, uint8, 1 where occupied.

        Raises:
            OutputError: The cache cannot be written.
        """
        described = {"format": FORMAT, "count": count, "shape": shape, **key}
        text = json.dumps(described, sort_keys=True)
        path = self.folder / f"{hashlib.sha256(text.encode()).hexdigest()[:40]}.npy"
        bits = -(-int(np.prod(shape)) // 8)
        if (packed := _read(path, (count, bits))) is None:
            packed = np.empty((count, bits), np.uint8)
            for row, grid in zip(packed, make(), strict=True):
                row[:] = np.packbits(grid.reshape(-1))
            with atomic_open(path, "wb") as stream:
                np.save(stream, packed, allow_pickle=False)
        return PackedGrids(packed, shape)


class PackedGrids:
    """Grids of one shape as packed bits; indexing unpacks.

    Args:
        packed: (n, bits / 8) uint8.
        shape: Shape of one grid.
    """

    def __init__(self, packed: NDArray[np.uint8], shape: tuple[int, ...]) -> None:
        self._packed = packed
        self.shape = shape

    def __len__(self) -> int:
        return len(self._packed)

    def __getitem__(self, chosen: slice | NDArray[np.int64]) -> NDArray[np.uint8]:
        """(k, *shape) uint8 grids of the chosen rows."""
        rows = np.asarray(self._packed[chosen])
        flat = np.unpackbits(rows, axis=1, count=int(np.prod(self.shape)))
        return flat.reshape(len(rows), *self.shape)


def _read(path: Path, expected: tuple[int, int]) -> NDArray[np.uint8] | None:
    try:
        packed = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    return packed if packed.shape == expected and packed.dtype == np.uint8 else None
