"""Segmentation of the object that stands on the floor."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.sensing import _native
from circumspect.sensing.depth_noise import DepthNoise
from circumspect.sensing.floor_plane import FloorPlane, FloorProblem, floor_problem
from circumspect.sensing.rgbd_frame import RgbdFrame
from circumspect.sensing.segmentation import Segmentation, continuous_pixels

BLOCK_PX = 2
"""Side of the blocks that are segmented as a whole, because they become one point [px]."""
FLOOR_STEP, MIN_FLOOR_POINTS = 8, 110
"""Spacing of the pixels to which the floor is fitted [px], and their minimum number."""
MAX_KNOWN_POINTS = 10_000
"""Maximum number of points of the known object that are compared."""
SHARED_CELLS = 2
"""Minimum number of plan-view cells that a cluster must have in common with the known object."""
RIM_FRACTION = 60
"""Inverse width of the image rim, relative to the height of the image."""
MIN_CUT_COLUMNS = 0.8
"""Fraction of columns at the upper rim above which a cluster is cut off there."""
MAX_RANGE_FRACTION = 0.9
"""Fraction of the camera's range beyond which a surface may continue."""


@dataclass(frozen=True)
class GroundSegmentation(Segmentation):
    """Removes the floor at z = 0, then keeps the cluster in the centre of the image.

    Clusters are found in plan view, because from one viewpoint the legs of a table appear separated
    from its top. A cluster that is cut off by the image at the top and at a side is a wall, and not
    selected as object. Once the object is known, all clusters that touch its known points belong to
    it.

    Attributes:
        margin: Height up to which points belong to the floor [m] …
        sigmas: … in addition to this many standard deviations of the height.
        cell: Side of the plan-view cells [m]; gaps of up to one cell are bridged.
        min_pixels: Clusters with fewer pixels are outliers.
        noise: Noise and range of the camera; farther points are ignored.

    Raises:
        InputError: Cells below 1 mm, or clusters without a pixel.
    """

    margin: float = 0.012
    sigmas: float = 3.0
    cell: float = 0.04
    min_pixels: int = 60
    noise: DepthNoise = field(default_factory=DepthNoise)

    def __post_init__(self) -> None:
        if not 1e-3 <= self.cell <= 1:
            raise InputError(f"the cell must be from 0.001 to 1 m, not {self.cell:g}")
        if self.min_pixels < 1:
            raise InputError(f"min_pixels must be at least 1, not {self.min_pixels}")

    def object_mask(
        self, frame: RgbdFrame, known_xyz: NDArray[np.floating] | None = None
    ) -> NDArray[np.bool_]:
        """See `Segmentation.object_mask`."""
        mask = continuous_pixels(frame.depth, frame.camera, self.noise)
        self._keep_above_floor(frame, self._floor(frame, mask), mask)
        if np.count_nonzero(mask) < self.min_pixels:
            return np.zeros_like(mask)
        self._keep_cluster(frame, mask, known_xyz)
        return mask

    def problem(self, frame: RgbdFrame) -> FloorProblem | None:
        """See `Segmentation.problem`: the floor must be at z = 0."""
        return floor_problem(frame, self.noise)

    def _floor(self, frame: RgbdFrame, mask: NDArray[np.bool_]) -> FloorPlane:
        points = frame.sparse_points_map(FLOOR_STEP, mask)
        return FloorPlane().refined(points, min_points=MIN_FLOOR_POINTS)

    def _keep_above_floor(
        self, frame: RgbdFrame, floor: FloorPlane, mask: NDArray[np.bool_]
    ) -> None:
        """Remove the floor, and depths beyond the range of the sensor, from the mask."""
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
            # Depths beyond the range come from a wrong unit or decoder.
            self.noise.farthest,
            mask,
        )

    def _keep_cluster(
        self,
        frame: RgbdFrame,
        mask: NDArray[np.bool_],
        known_xyz: NDArray[np.floating] | None,
    ) -> None:
        """Remove everything above the floor that is not the object from the mask."""
        from scipy import ndimage

        camera = frame.camera
        intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
        is_known = known_xyz is not None and len(known_xyz) > 0
        block = BLOCK_PX if is_known else 1
        flat, counts, low_x, low_y, rows, columns = _native.plan_cells(
            frame.depth, mask, intrinsics, frame.pose.as_matrix(), self.cell, block
        )
        if len(counts) == 0:
            # Too far apart for a plan-view grid: there are no clusters.
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
        candidates = sizes >= self.min_pixels
        if known_xyz is not None and is_known:
            some = known_xyz[:: max(1, len(known_xyz) // MAX_KNOWN_POINTS), :2]
            places = (some - [low_x, low_y]) / self.cell
            chosen = candidates & _touching_known(labels, count, places)
        else:
            chosen = self._complete_clusters(of_cell[flat], candidates, frame, mask)
        _native.keep_cells(flat, chosen[of_cell], mask, block)

    def _complete_clusters(
        self,
        of_point: NDArray[np.intp],
        candidates: NDArray[np.bool_],
        frame: RgbdFrame,
        mask: NDArray[np.bool_],
    ) -> NDArray[np.bool_]:
        """Like `_central_cluster`, but without walls, which are cut off by the image."""
        v, u = np.nonzero(mask)
        left = candidates.copy()
        while left.any():
            chosen = _central_cluster(of_point, left, frame, mask)
            ours = chosen[of_point]
            if not self._is_cut_off(frame, v[ours], u[ours]):
                return chosen
            left &= ~chosen
        return left

    def _is_cut_off(self, frame: RgbdFrame, v: NDArray[np.intp], u: NDArray[np.intp]) -> bool:
        """Whether a cluster is cut off at the top and at a side.

        Args:
            frame: The frame.
            v: (n,) rows of its pixels.
            u: (n,) columns of them.
        """
        rim, width = max(1, frame.camera.height // RIM_FRACTION), frame.camera.width
        if len(np.unique(u[v < rim])) < MIN_CUT_COLUMNS * len(np.unique(u)):
            return False
        reach = np.percentile(frame.depth[v, u], 95)
        return bool(
            u.min() < rim
            or u.max() >= width - rim
            or reach > MAX_RANGE_FRACTION * self.noise.farthest
        )


def _touching_known(
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


def _central_cluster(
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
