"""Simulated scans of training objects by an RGB-D camera, from one view to a full orbit.

Depth images of the object in random surroundings are rendered, made noisy by `DepthNoise`,
segmented with segmentation errors, and fused with registration errors. There is no rotation about
the vertical: the object keeps its heading, and the camera moves around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.placed_object import Neighbour, PlacedObject
from circumspect.datasets.scan_view import HALF_IMAGE, ScanView
from circumspect.datasets.segmentation_errors import SegmentationErrors
from circumspect.datasets.surroundings import RoomSurroundings, Wall
from circumspect.errors import InputError

Chance = np.random.Generator
CHANCES = (
    "mirror", "rescale", "complete", "single", "occluded", "beside", "furnished", "merged",
    "cluttered", "walled", "leak", "boxed", "cut", "lowered", "thinned", "strays",
)  # fmt: skip
ADDED_LATER = ("rescale", "furnished", "merged", "thinned")
"""Probabilities that older documents lack."""
MIN_VOXELS = 60
"""Minimum number of voxels; a scan with fewer is drawn again."""
VOXELS = 96.0
"""Voxels along the longest visible side."""
SAMPLES = 12_000
"""Points on a complete surface."""
HIDDEN_BELOW = (0.1, 0.55)
"""Fraction of the object's height below which it is hidden, like a chair at a table."""
MERGED_WITHIN = 0.3
"""Maximum distance from the object's box of furniture that is segmented with it [m]."""
THINNED = (0.02, 0.6)
"""Fraction of the points that a thinned scan keeps, drawn log-uniformly."""


@dataclass(frozen=True)
class TrainingScan:
    """A simulated scan of an object.

    Attributes:
        points_xyz: (n, 3) float32 [m] the segmented surface, thinned to voxels, map frame.
        origins_xyz: (m, 3) float32 [m] origins of rays.
        ends_xyz: (m, 3) float32 [m] ends of rays, on the object or behind it.
        views_xyz: (v, 3) float32 [m] positions of the camera.
    """

    points_xyz: NDArray[np.float32]
    origins_xyz: NDArray[np.float32]
    ends_xyz: NDArray[np.float32]
    views_xyz: NDArray[np.float32]


@dataclass(frozen=True)
class ScanAugmentation:
    """Ranges of the random scans.

    Attributes:
        mirror: Probability of swapping left and right (x to -x).
        stretch: Each axis is scaled by e^u, u uniform in ± this.
        resize: The same for the scale of the whole object.
        rescale: Probability that an object of unknown unit gets another size of its class.
        complete: Probability of the whole surface, including inner faces, as in a file; without
            rays, but with noise and holes.
        single: Probability of a scan of one view; others have an arc.
        most_views: Number of views of a full orbit.
        heights: Range of the camera's height above the floor [m].
        distances: Range of the camera's distance, in units of the distance at which the object fits
            the image; below 1 the image truncates it.
        nearest: Minimum distance of the camera from the object's centre [m].
        farthest: Maximum distance of the camera from the object's centre [m].
        occluded: Probability of one or two boxes in front of the object.
        beside: Probability of a box next to the object.
        furnished: Probability of other furniture next to, under or over the object.
        merged: Probability that nearby parts of this furniture are segmented with the object.
        cluttered: Probability of one to three boxes on or against the object that are segmented
            with it.
        walled: Probability of a wall behind the object.
        leak: Probability that pixels next to the object's are segmented with it.
        boxed: Probability that the segmentation is a box with its whole content.
        cut: Probability that the segmentation loses everything beyond a plane.
        lowered: Probability that the lower part is hidden from all sides.
        thinned: Probability that few of the points remain.
        floor_cut: Range of the height below which the object is cut off [m].
        registration: Largest standard deviation of a view's pose: [m], and [deg] about the
            vertical in hundredths of that.
        strays: Probability of stray points.
    """

    mirror: float = 0.5
    stretch: float = 0.12
    resize: float = 0.15
    rescale: float = 0.5
    complete: float = 0.35
    single: float = 0.4
    most_views: int = 10
    heights: tuple[float, float] = (0.35, 1.7)
    distances: tuple[float, float] = (0.85, 2.0)
    nearest: float = 0.75
    farthest: float = 5.0
    occluded: float = 0.4
    beside: float = 0.25
    furnished: float = 0.35
    merged: float = 0.5
    cluttered: float = 0.35
    walled: float = 0.3
    leak: float = 0.3
    boxed: float = 0.2
    cut: float = 0.25
    lowered: float = 0.15
    thinned: float = 0.15
    floor_cut: tuple[float, float] = (-0.01, 0.07)
    registration: float = 0.012
    strays: float = 0.2

    def __post_init__(self) -> None:
        for name in CHANCES:
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"{name} must lie in 0 … 1, not {getattr(self, name)}")
        if self.most_views < 1:
            raise InputError(f"most_views must be at least 1, not {self.most_views}")

    @classmethod
    def from_dict(cls, document: Any) -> ScanAugmentation:
        """Read a document from `dataclasses.asdict`, also after JSON.

        Probabilities that an older document lacks are 0.

        Raises:
            InputError: It is another document.
        """
        known = {field.name for field in fields(cls)}
        if not isinstance(document, Mapping) or set(document) - known:
            raise InputError(f"a scan's settings must name {', '.join(sorted(known))}")
        values: dict[str, Any] = dict.fromkeys(ADDED_LATER, 0.0)
        values |= {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in document.items()
        }
        return cls(**values)

    def scan(
        self, caster: ObjectCaster, rng: Chance, sizes: tuple[float, float] = (1.0, 1.0)
    ) -> TrainingScan:
        """Scan an object once.

        Args:
            caster: The object [m], z up.
            rng: Random generator.
            sizes: Range of scales, see `LabelledSurfaces.size_factors`.

        Returns:
            A scan of at least `MIN_VOXELS` points, if a few attempts find one.
        """
        stretch = self._stretch(rng, sizes)
        if rng.random() < self.complete:
            return _complete(caster, stretch, rng)
        found = None
        for _ in range(8):
            found = self._single_scan(caster, stretch, rng)
            if len(found.points_xyz) >= MIN_VOXELS:
                return found
        assert found is not None
        return found

    def _stretch(self, rng: Chance, sizes: tuple[float, float]) -> NDArray[np.float64]:
        factors = np.exp(rng.uniform(-self.stretch, self.stretch, 3))
        if rng.random() < self.rescale:
            factors *= np.exp(rng.uniform(*np.log(sizes)))
        factors *= np.exp(rng.uniform(-self.resize, self.resize))
        if rng.random() < self.mirror:
            factors[0] = -factors[0]
        return factors

    def _single_scan(
        self, caster: ObjectCaster, stretch: NDArray[np.float64], rng: Chance
    ) -> TrainingScan:
        corners = np.sort(caster.corners_xyz * stretch, axis=0)
        placed = PlacedObject(corners[0], corners[1])
        views_xyz = self._views(placed, rng)
        around = self._surroundings(placed, views_xyz, rng)
        views_xyz = np.array(
            [v for v in views_xyz if not any(wall.is_behind(v) for wall in around.walls)]
        )
        segmentation = self._segmentation(placed, rng)
        noise_m = abs(rng.normal()) * self.registration
        shown = [
            ScanView.taken(caster, stretch, placed, around, view, segmentation, noise_m, rng)
            for view in views_xyz
        ]
        points = np.concatenate([one.points_xyz for one in shown])
        if len(points):
            points = segmentation.finished(_voxelised(points), rng)
        return TrainingScan(
            points.astype(np.float32),
            np.concatenate([one.origins_xyz for one in shown]).astype(np.float32),
            np.concatenate([one.ends_xyz for one in shown]).astype(np.float32),
            views_xyz.astype(np.float32),
        )

    def _views(self, placed: PlacedObject, rng: Chance) -> NDArray[np.float64]:
        """(v, 3) [m] positions along an arc around the object."""
        fitting = placed.radius / min(HALF_IMAGE) / 0.95
        away = np.clip(
            fitting * rng.uniform(*self.distances), self.nearest + placed.reach, self.farthest
        )
        start, height = rng.uniform(0, 2 * pi), rng.uniform(*self.heights)
        if rng.random() < self.single:
            headings = np.array([start])
        else:
            share = rng.random() ** 1.2
            arc = 2 * pi * share
            count = max(2, round(2 + share * (self.most_views - 2) * rng.uniform(0.6, 1.0)))
            headings = start + np.linspace(0, arc, count, endpoint=share < 0.95)
        distances = away * np.exp(rng.normal(0, 0.05, len(headings)))
        heights = np.maximum(height + rng.normal(0, 0.03, len(headings)), 0.2)
        middle = placed.middle
        return np.stack(
            [
                middle[0] + distances * np.cos(headings),
                middle[1] + distances * np.sin(headings),
                heights,
            ],
            axis=1,
        )

    def _surroundings(
        self, placed: PlacedObject, views_xyz: NDArray[np.float64], rng: Chance
    ) -> RoomSurroundings:
        first = views_xyz[0] - placed.middle
        bearing = float(np.arctan2(first[1], first[0]))
        walls, boxes = [], []
        if rng.random() < self.walled:
            normal = bearing + rng.uniform(-1.2, 1.2)
            normal_xy = np.array([np.cos(normal), np.sin(normal)])
            gap = rng.uniform(0.0, 0.3) if rng.random() < 0.7 else rng.uniform(0.3, 2.0)
            back = placed.middle[:2] - normal_xy * (placed.along(-normal_xy) + gap)
            walls.append(Wall(back, normal_xy))
        if rng.random() < self.occluded:
            boxes += [placed.occluder(bearing, rng) for _ in range(rng.integers(1, 3))]
        if rng.random() < self.beside:
            boxes.append(placed.neighbour(rng))
        if rng.random() < self.cluttered:
            boxes += [placed.clutter(rng) for _ in range(rng.integers(1, 4))]
        free = tuple(box for box in boxes if all(map(box.is_clear_of, views_xyz)))
        furniture: tuple[Neighbour, ...] = ()
        if rng.random() < self.furnished:
            piece = Neighbour.drawn(placed.low, placed.high, rng)
            furniture = (piece,) if all(map(piece.is_clear_of, views_xyz)) else ()
        return RoomSurroundings(tuple(walls), free, furniture)

    def _segmentation(self, placed: PlacedObject, rng: Chance) -> SegmentationErrors:
        """The errors of one scan's segmentation, the same in all views."""
        floor_cut = float(rng.uniform(*self.floor_cut))
        if rng.random() < self.lowered:
            floor_cut = float(placed.high[2] * rng.uniform(*HIDDEN_BELOW))
        leak, box, plane, merged, kept_share, strays = 0, None, None, None, 1.0, 0
        if rng.random() < self.leak:
            leak = int(rng.integers(1, 5))
        if rng.random() < self.boxed:
            margin = rng.uniform(0.0, 0.12, 3)
            box = placed.low - margin, placed.high + margin
            floor_cut = min(floor_cut, float(rng.uniform(-0.03, 0.05)))
        if rng.random() < self.cut:
            normal = rng.normal(size=3) * (1.0, 1.0, 0.5)
            plane = normal / np.linalg.norm(normal), float(rng.uniform(0.5, 0.95))
        if rng.random() < self.merged:
            margin = rng.uniform(0.0, MERGED_WITHIN, 3)
            merged = placed.low - margin, placed.high + margin
        if rng.random() < self.thinned:
            kept_share = float(np.exp(rng.uniform(*np.log(THINNED))))
        if rng.random() < self.strays:
            strays = int(rng.integers(1, 25))
        return SegmentationErrors(floor_cut, leak, box, plane, merged, kept_share, strays)


def _complete(caster: ObjectCaster, stretch: NDArray[np.float64], rng: Chance) -> TrainingScan:
    """The whole surface with noise, sometimes thinned, and with holes."""
    points = caster.mesh.sampled(SAMPLES, rng).points_xyz * stretch
    size = float(np.ptp(points, axis=0).max()) / 2
    points = points + rng.normal(size=points.shape) * rng.uniform(0, 0.01) * size
    keep = np.ones(len(points), bool)
    if rng.random() < 0.5:
        keep &= rng.random(len(points)) < rng.uniform(0.3, 1.0)
    if rng.random() < 0.5:
        radius = rng.uniform(0.05, 0.25) * size
        for centre in points[rng.integers(len(points), size=rng.integers(1, 5))]:
            keep &= ((points - centre) ** 2).sum(axis=1) > radius**2
    none = np.empty((0, 3), np.float32)
    kept = points[keep] if keep.any() else points
    return TrainingScan(kept.astype(np.float32), none, none, none)


def _voxelised(points: NDArray[np.floating]) -> NDArray[np.floating]:
    """One point per voxel, so that near surfaces do not dominate."""
    side = max(float(np.ptp(points, axis=0).max()) / VOXELS, 1e-4)
    cells = np.floor((points - points.min(axis=0)) / side).astype(np.int64)
    keys = (cells[:, 0] << 40) | (cells[:, 1] << 20) | cells[:, 2]
    _, first = np.unique(keys, return_index=True)
    return points[first]
