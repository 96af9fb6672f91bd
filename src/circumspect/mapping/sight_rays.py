"""The rays along which the object was seen, thinned so that they stay few."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

END_CELL = 0.03
"""Rays whose ends are in the same cell of this side [m] …"""
ORIGIN_CELL = 0.5
"""… and whose origins are in the same cell of this side [m] are one ray."""
END_BITS, ORIGIN_BITS = 15, 6


@dataclass(frozen=True, eq=False)
class SightRays:
    """Rays from a camera to what it saw.

    Attributes:
        keys: (n,) int64, ascending: the cells of end and origin.
        origins_xyz: (n, 3) float32 [m].
        ends_xyz: (n, 3) float32 [m].
        on_object: (n,) bool: the ray ends on the object, not on what is behind it.
    """

    keys: NDArray[np.int64]
    origins_xyz: NDArray[np.float32]
    ends_xyz: NDArray[np.float32]
    on_object: NDArray[np.bool_]

    @classmethod
    def empty(cls) -> SightRays:
        """No rays."""
        none = np.empty((0, 3), np.float32)
        return cls(np.empty(0, np.int64), none, none, np.empty(0, bool))

    def __len__(self) -> int:
        return len(self.keys)

    def with_frame(
        self,
        origin_xyz: NDArray[np.floating],
        ends_xyz: NDArray[np.floating],
        on_object: NDArray[np.bool_],
    ) -> SightRays:
        """These rays and those of one more frame that say something new.

        Args:
            origin_xyz: (3,) [m] the camera's place.
            ends_xyz: (m, 3) [m].
            on_object: (m,) bool.
        """
        origins = np.broadcast_to(np.asarray(origin_xyz, np.float32), (len(ends_xyz), 3))
        return self.with_rays(origins, ends_xyz, on_object)

    def with_rays(
        self,
        origins_xyz: NDArray[np.floating],
        ends_xyz: NDArray[np.floating],
        on_object: NDArray[np.bool_],
    ) -> SightRays:
        """These rays and those of others that say something new.

        Args:
            origins_xyz: (m, 3) [m].
            ends_xyz: (m, 3) [m].
            on_object: (m,) bool.
        """
        keys, first = np.unique(_keys(origins_xyz, ends_xyz, on_object), return_index=True)
        places = np.searchsorted(self.keys, keys)
        if len(self):
            new = self.keys[np.minimum(places, len(self) - 1)] != keys
            keys, first, places = keys[new], first[new], places[new]
        origins = origins_xyz[first].astype(np.float32)
        ends = ends_xyz[first].astype(np.float32)
        return SightRays(
            np.insert(self.keys, places, keys),
            np.insert(self.origins_xyz, places, origins, axis=0),
            np.insert(self.ends_xyz, places, ends, axis=0),
            np.insert(self.on_object, places, on_object[first]),
        )


def _keys(
    origins_xyz: NDArray[np.floating],
    ends_xyz: NDArray[np.floating],
    on_object: NDArray[np.bool_],
) -> NDArray[np.int64]:
    ends = np.floor(ends_xyz / END_CELL).astype(np.int64) & ((1 << END_BITS) - 1)
    origins = np.floor(origins_xyz / ORIGIN_CELL).astype(np.int64) & ((1 << ORIGIN_BITS) - 1)
    place = (origins[:, 0] << (2 * ORIGIN_BITS)) | (origins[:, 1] << ORIGIN_BITS) | origins[:, 2]
    key = (ends[:, 0] << (2 * END_BITS)) | (ends[:, 1] << END_BITS) | ends[:, 2]
    # 45 bits for the end, 18 for the origin; the sign bit tells the object from the rest.
    key |= place << (3 * END_BITS)
    return np.where(on_object, key, -key - 1)
