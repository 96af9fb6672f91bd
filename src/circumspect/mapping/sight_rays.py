"""The rays along which the object was seen, thinned so that they stay few."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.voxel_sums import first_rows, packed_cells
from circumspect.mapping import _native

END_CELL = 0.05
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

    def at_most(self, count: int) -> SightRays:
        """Themselves, or evenly chosen ones of them where they are more."""
        every = -(-len(self) // count)
        if every <= 1:
            return self
        return SightRays(
            self.keys[::every].copy(),
            self.origins_xyz[::every].copy(),
            self.ends_xyz[::every].copy(),
            self.on_object[::every].copy(),
        )

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
        keys, first = first_rows(_keys(origins_xyz, ends_xyz, on_object))
        return SightRays(
            *_native.merge_rays(
                self.keys,
                self.origins_xyz,
                self.ends_xyz,
                self.on_object,
                keys,
                origins_xyz[first].astype(np.float32),
                ends_xyz[first].astype(np.float32),
                on_object[first],
            )
        )


def _keys(
    origins_xyz: NDArray[np.floating],
    ends_xyz: NDArray[np.floating],
    on_object: NDArray[np.bool_],
) -> NDArray[np.int64]:
    # Of rays from one place the place is looked at once.
    places = origins_xyz[:1] if origins_xyz.strides[0] == 0 else origins_xyz
    origins = packed_cells(places, ORIGIN_CELL, ORIGIN_BITS)
    ends = packed_cells(ends_xyz, END_CELL, END_BITS)
    # 45 bits for the end, 18 for the origin; the sign bit tells the object from the rest.
    key = ends | (origins << (3 * END_BITS))
    return np.where(on_object, key, -key - 1)
