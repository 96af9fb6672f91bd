"""The object is what stands on the floor, apart from what else stands there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.sensing import _native
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_check import FloorFault, floor_fault
from circumspect.sensing.floor_plane import FloorPlane
from circumspect.sensing.flying_pixels import continuous_pixels
from circumspect.sensing.rgbd_frame import RgbdFrame
from circumspect.sensing.segmentation import Segmentation

BLOCK_PX = 2
"""Blocks of this side [px] belong to the object as a whole, as they become one point of it."""
FLOOR_STEP, MIN_FLOOR_POINTS = 8, 110
"""The floor is fitted to one pixel of each block of this side [px], and to so many at least."""
KNOWN = 10_000
"""So many points of the known object tell where it stands."""
SHARED_CELLS = 2
"""Plan-view cells that a cluster shares with the known object before it belongs to it."""
RIM = 60
"""The rim of a picture is one of so many parts of its height wide."""
CUT_OFF = 0.8
"""What meets the upper rim with this share of its columns has its upper end out of view."""
FAR = 0.9
"""What reaches this share of the camera's range may go on beyond it."""


@dataclass(frozen=True)
class GroundSegmentation(Segmentation):
    """Takes away the floor at z = 0, then keeps the cluster the camera looks at.

    Clusters are found in plan view, not in space: from one place the legs of a table seem to
    hang apart from its top, yet they stand below it. What goes on beyond the picture, upwards and
    to a side, is a wall and no object to begin with. Once the object is known, every cluster that
    stands where the object was seen before belongs to it.

    Attributes:
        margin: Everything closer to the floor than this is floor [m] …
        sigmas: … and this many standard deviations of the height on top of it.
        cell: Side of the plan-view cells [m]; gaps of up to one cell are bridged.
        fewest: Clusters of fewer pixels are specks.
        noise: The camera's noise and range; nothing beyond it is looked at.

    Raises:
        InputError: Cells below 1 mm, or clusters of no pixel.
    """

    margin: float = 0.012
    sigmas: float = 3.0
    cell: float = 0.04
    fewest: int = 60
    noise: DepthNoise = field(default_factory=DepthNoise)

    def __post_init__(self) -> None:
        if not 1e-3 <= self.cell <= 1:
            raise InputError(f"cells are 0.001 to 1 m wide, not {self.cell:g}")
        if self.fewest < 1:
            raise InputError(f"a cluster has 1 pixel or more, not {self.fewest}")

    def object_mask(
        self, frame: RgbdFrame, known_xyz: NDArray[np.floating] | None = None
    ) -> NDArray[np.bool_]:
        """See `Segmentation.object_mask`."""
        mask = continuous_pixels(frame.depth, frame.camera, self.noise)
        self._keep_above_floor(frame, self._floor(frame, mask), mask)
        if np.count_nonzero(mask) < self.fewest:
            return np.zeros_like(mask)
        self._keep_cluster(frame, mask, known_xyz)
        return mask

    def fault(self, frame: RgbdFrame) -> FloorFault | None:
        """See `Segmentation.fault`: the floor must be where z is 0."""
        return floor_fault(frame, self.noise)

    def _floor(self, frame: RgbdFrame, mask: NDArray[np.bool_]) -> FloorPlane:
        points = frame.sparse_points_map(FLOOR_STEP, mask)
        return FloorPlane().refined(points, fewest=MIN_FLOOR_POINTS)

    def _keep_above_floor(
        self, frame: RgbdFrame, floor: FloorPlane, mask: NDArray[np.bool_]
    ) -> None:
        """Take out of the mask what is floor, and what the sensor can not have seen."""
        up = np.array([-floor.slope_x, -floor.slope_y, 1.0])
        matrix, camera = frame.pose.as_matrix(), frame.camera
        x, y, z = (float(value) for value in matrix[:3, :3].T @ up)
        _native.keep_above(
            frame.depth,
            (x, y, z, float(up @ matrix[:3, 3] - floor.offset)),
            (camera.fx, camera.fy, camera.cx, camera.cy),
            self.noise.coefficients(camera),
            self.margin,
            self.sigmas,
            # What is beyond is no object: a wrong unit, a wrong decoder.
            self.noise.farthest,
            mask,
        )

    def _keep_cluster(
        self,
        frame: RgbdFrame,
        mask: NDArray[np.bool_],
        known_xyz: NDArray[np.floating] | None,
    ) -> None:
        """Take out of the mask, what is above the floor, what does not belong to the object."""
        from scipy import ndimage

        camera = frame.camera
        intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
        is_known = known_xyz is not None and len(known_xyz) > 0
        block = BLOCK_PX if is_known else 1
        flat, counts, low_x, low_y, rows, columns = _native.plan_cells(
            frame.depth, mask, intrinsics, frame.pose.as_matrix(), self.cell, block
        )
        if len(counts) == 0:
            # So far apart that no plan holds them: nothing that is near each other.
            mask[:] = False
            return
        joined = ndimage.binary_dilation(
            counts.reshape(rows, columns) >= 3, np.ones((2, 2)), origin=-1
        )
        found = ndimage.label(joined, np.ones((3, 3)))
        labels, count = cast("tuple[NDArray[np.intp], int]", found)
        of_cell = labels.ravel()
        sizes = np.bincount(of_cell, counts, minlength=count + 1)
        sizes[0] = 0
        candidates = sizes >= self.fewest
        if known_xyz is not None and is_known:
            some = known_xyz[:: max(1, len(known_xyz) // KNOWN), :2]
            places = (some - [low_x, low_y]) / self.cell
            chosen = candidates & _standing_on(labels, count, places)
        else:
            chosen = self._seen_whole(of_cell[flat], candidates, frame, mask)
        _native.keep_cells(flat, chosen[of_cell], mask, block)

    def _seen_whole(
        self,
        of_point: NDArray[np.intp],
        candidates: NDArray[np.bool_],
        frame: RgbdFrame,
        mask: NDArray[np.bool_],
    ) -> NDArray[np.bool_]:
        """As `_looked_at`, but walls, which go on beyond the picture, are passed over."""
        v, u = np.nonzero(mask)
        left = candidates.copy()
        while left.any():
            chosen = _looked_at(of_point, left, frame, mask)
            ours = chosen[of_point]
            if not self._goes_on(frame, v[ours], u[ours]):
                return chosen
            left &= ~chosen
        return left

    def _goes_on(self, frame: RgbdFrame, v: NDArray[np.intp], u: NDArray[np.intp]) -> bool:
        """Whether neither the upper end of something is in view nor both of its sides are.

        Args:
            frame: The frame.
            v: (n,) rows of its pixels.
            u: (n,) columns of them.
        """
        rim, width = max(1, frame.camera.height // RIM), frame.camera.width
        if len(np.unique(u[v < rim])) < CUT_OFF * len(np.unique(u)):
            return False
        reach = np.percentile(frame.depth[v, u], 95)
        return bool(u.min() < rim or u.max() >= width - rim or reach > FAR * self.noise.farthest)


def _standing_on(
    labels: NDArray[np.intp], count: int, places: NDArray[np.floating]
) -> NDArray[np.bool_]:
    """(count + 1,) the clusters that stand where known points of the object are."""
    cells = places.astype(np.intp)
    inside = ((places >= 0) & (cells < labels.shape)).all(axis=1)
    known = np.zeros(labels.shape, bool)
    known[cells[inside, 0], cells[inside, 1]] = True
    shared = np.bincount(labels[known], minlength=count + 1)
    chosen = shared >= SHARED_CELLS
    chosen[0] = False
    return chosen


def _looked_at(
    of_point: NDArray[np.intp],
    candidates: NDArray[np.bool_],
    frame: RgbdFrame,
    mask: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """The nearest of the clusters near the middle of the picture, as a (count + 1,) choice.

    A wall behind the object fills more of the picture, clutter beside it may be nearer: only
    clusters with at least a tenth of the weight of the heaviest stay, weighted towards the
    middle column, and of these the nearest is taken.
    """
    chosen = np.zeros(len(candidates), bool)
    if not candidates.any():
        return chosen
    v, u = np.nonzero(mask)
    camera = frame.camera
    central = np.exp(-0.5 * ((u - camera.cx) / (camera.width / 8)) ** 2)
    weight = np.bincount(of_point, central, minlength=len(candidates)) * candidates
    depth = frame.depth[v, u]
    central_enough = np.flatnonzero(weight >= 0.1 * weight.max())
    nearest = [float(np.percentile(depth[of_point == label], 5)) for label in central_enough]
    chosen[central_enough[int(np.argmin(nearest))]] = True
    return chosen
