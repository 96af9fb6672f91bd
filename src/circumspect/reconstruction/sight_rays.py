"""Rays from the camera to the points that it observed, thinned to a bounded density."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry.voxel_sums import first_rows, packed_cells
from circumspect.reconstruction import _native

END_CELL_M = 0.05
"""Side of the cells for ray ends [m]. One ray is kept per pair of end cell and origin cell."""
ORIGIN_CELL_M = 0.5
"""Side of the cells for ray origins [m]."""
END_BITS, ORIGIN_BITS = 15, 6


@dataclass(frozen=True, eq=False)
class SightRays:
    """Rays from camera positions to observed points, map frame.

    Attributes:
        keys: (n,) int64, ascending: the cells of end and origin.
        origins_xyz: (n, 3) float32 [m].
        ends_xyz: (n, 3) float32 [m].
        on_object: (n,) bool, whether the ray ends on the object, not on the background.
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

    def __getitem__(self, rows: slice | NDArray[np.intp]) -> SightRays:
        """A selection of the rays, in ascending order."""
        return SightRays(
            np.ascontiguousarray(self.keys[rows]),
            np.ascontiguousarray(self.origins_xyz[rows]),
            np.ascontiguousarray(self.ends_xyz[rows]),
            np.ascontiguousarray(self.on_object[rows]),
        )

    def subsampled(self, max_rays: int) -> SightRays:
        """Every k-th ray, with the smallest k that leaves at most `max_rays`."""
        every = -(-len(self) // max_rays)
        return self if every <= 1 else self[::every]

    def with_frame(
        self,
        origin_xyz: NDArray[np.floating],
        ends_xyz: NDArray[np.floating],
        on_object: NDArray[np.bool_],
    ) -> SightRays:
        """These rays and those of one more frame; see `with_rays`.

        Args:
            origin_xyz: (3,) [m] position of the camera.
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
        """These rays, and the given rays whose pair of cells has no ray yet.

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
    # A broadcast origin is packed once.
    distinct = origins_xyz[:1] if origins_xyz.strides[0] == 0 else origins_xyz
    origins = packed_cells(distinct, ORIGIN_CELL_M, ORIGIN_BITS)
    ends = packed_cells(ends_xyz, END_CELL_M, END_BITS)
    # 45 bits for the end and 18 for the origin; the sign bit marks rays that miss the object.
    key = ends | (origins << (3 * END_BITS))
    return np.where(on_object, key, -key - 1)
