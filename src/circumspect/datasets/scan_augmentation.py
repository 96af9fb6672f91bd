"""What an RGB-D camera on a robot sees of a training object, from one view to a full orbit.

Depth images of the object and of random surroundings are rendered, made noisy by `DepthNoise`,
segmented with the errors of a segmentation, and fused with the errors of a registration. Never a
rotation about the vertical: the object keeps its heading, only the camera goes round it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import pi, radians, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.datasets.neighbour import Neighbour
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.placed_object import PlacedObject
from circumspect.datasets.segmentation_errors import LEAK_STEP, SegmentationErrors
from circumspect.datasets.surroundings import NOTHING, Surroundings, Wall
from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.sensing import DepthNoise

Chance = np.random.Generator
HALF_IMAGE = (tan(radians(29.0)), tan(radians(22.5)))
"""Half width and half height of the Xtion's image at 1 m."""
FOCAL = 570.3
"""Of the Xtion PRO [px]."""
ACROSS = 80
"""Rays across the object; finer than the cells of a grid, coarser than a camera's pixels."""
AROUND = 1.3
"""The rendered window is so many times as large as the object."""
CHANCES = (
    "mirror", "rescale", "complete", "single", "occluded", "beside", "furnished", "merged",
    "cluttered", "walled", "leak", "boxed", "cut", "lowered", "thinned", "strays",
)  # fmt: skip
ADDED_LATER = ("rescale", "furnished", "merged", "thinned")
"""Chances that older documents lack."""
FEWEST = 60
"""Voxels; a view that shows less is no scan, and another one is drawn."""
VOXELS = 96.0
"""Voxels along the longest side of what is seen."""
SAMPLES = 12_000
"""Points on a complete surface."""
RAYS_A_VIEW = 2500
"""Rays that are traced for the free space."""


@dataclass(frozen=True)
class SimulatedScan:
    """What a simulated scan holds of an object.

    Attributes:
        points_xyz: (n, 3) float32 [m] the segmented surface, thinned to voxels, map frame.
        origins_xyz: (m, 3) float32 [m] where rays begin.
        ends_xyz: (m, 3) float32 [m] where they end, on the object or behind it.
        views_xyz: (v, 3) float32 [m] where the camera was.
    """

    points_xyz: NDArray[np.float32]
    origins_xyz: NDArray[np.float32]
    ends_xyz: NDArray[np.float32]
    views_xyz: NDArray[np.float32]


@dataclass(frozen=True)
class ScanAugmentation:
    """Ranges of the random scans.

    Attributes:
        mirror: Chance to swap left and right (x to -x).
        stretch: Each axis is scaled by e^u, u uniform in ± this.
        resize: So is the whole object.
        rescale: Chance that an object of unknown unit takes another size of its class.
        complete: Chance that the whole surface is taken, inner faces and all, as a file holds it;
            no rays then, but noise and holes.
        single: Chance of a scan of one view; the others have an arc.
        most_views: Views of a full orbit.
        heights: Of the camera above the floor [m].
        distances: Of the camera, in units of the distance at which the object fits the image; below
            1 the image cuts it off.
        nearest: The camera is at least so far from the object's middle [m].
        farthest: And at most so far [m].
        occluded: Chance of one or two boxes before the object.
        beside: Chance of a box that stands next to the object.
        furnished: Chance of another piece of furniture next to the object, under or over it.
        merged: Chance that a segmentation takes what is near of such a piece for the object.
        cluttered: Chance of one to three things on the object or against it that a segmentation
            takes for a part of it.
        walled: Chance of a wall behind the object.
        leak: Chance that a segmentation takes in what is next to the object's pixels.
        boxed: Chance that a segmentation is a box, with everything in it.
        cut: Chance that a segmentation loses what lies beyond a plane.
        lowered: Chance that something that stands all round hides the lower part.
        thinned: Chance that few of the points are left.
        floor_cut: Range of the height below which nothing is the object [m].
        registration: Largest standard deviation of a view's pose: [m], and [deg] about the
            vertical in hundredths of that.
        strays: Chance of stray points.
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
        """Read back what `dataclasses.asdict` made, also after JSON.

        What a document of before does not name was not simulated then.

        Raises:
            InputError: Not such a document.
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
    ) -> SimulatedScan:
        """Scan an object once.

        Args:
            caster: The object [m], z up.
            rng: Source of all chance.
            sizes: By how much it may shrink and grow, see `LabelledSurfaces.size_factors`.

        Returns:
            A scan of at least `FEWEST` points, as far as a few tries find one.
        """
        stretch = self._stretch(rng, sizes)
        if rng.random() < self.complete:
            return _complete(caster, stretch, rng)
        found = None
        for _ in range(8):
            found = self._once(caster, stretch, rng)
            if len(found.points_xyz) >= FEWEST:
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

    def _once(
        self, caster: ObjectCaster, stretch: NDArray[np.float64], rng: Chance
    ) -> SimulatedScan:
        corners = np.sort(caster.corners_xyz * stretch, axis=0)
        placed = PlacedObject(corners[0], corners[1])
        views_xyz = self._views(placed, rng)
        around = self._surroundings(placed, views_xyz, rng)
        views_xyz = np.array(
            [v for v in views_xyz if not any(wall.is_behind(v) for wall in around.walls)]
        )
        segmentation = SegmentationErrors.drawn(self, placed, rng)
        noise_m = abs(rng.normal()) * self.registration
        shown = [
            _View.taken(caster, stretch, placed, around, view, segmentation, noise_m, rng)
            for view in views_xyz
        ]
        points = np.concatenate([one.points_xyz for one in shown])
        if len(points):
            points = segmentation.finished(_voxelised(points), rng)
        return SimulatedScan(
            points.astype(np.float32),
            np.concatenate([one.origins_xyz for one in shown]).astype(np.float32),
            np.concatenate([one.ends_xyz for one in shown]).astype(np.float32),
            views_xyz.astype(np.float32),
        )

    def _views(self, placed: PlacedObject, rng: Chance) -> NDArray[np.float64]:
        """(v, 3) [m] places along an arc round the object."""
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
    ) -> Surroundings:
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
        return Surroundings(tuple(walls), free, furniture)


def _complete(caster: ObjectCaster, stretch: NDArray[np.float64], rng: Chance) -> SimulatedScan:
    """The whole surface with noise, thinned now and then, and with holes."""
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
    return SimulatedScan(kept.astype(np.float32), none, none, none)


@dataclass(frozen=True)
class _View:
    """What one depth image adds."""

    points_xyz: NDArray[np.floating]
    origins_xyz: NDArray[np.floating]
    ends_xyz: NDArray[np.floating]

    @classmethod
    def taken(
        cls, caster: ObjectCaster, stretch: NDArray[np.float64], placed: PlacedObject,
        around: Surroundings, view_xyz: NDArray[np.float64], segmentation: SegmentationErrors,
        noise_m: float, rng: Chance,
    ) -> _View:  # fmt: skip
        camera, R_map_camera = _window(placed, view_xyz, rng)
        rays = camera.rays_xyz.reshape(-1, 3).astype(np.float32) @ R_map_camera.T
        hits = caster.hits(view_xyz, rays, stretch).nearer(around.hits(view_xyz, rays))
        size = camera.height, camera.width
        true = np.where(hits.kind == NOTHING, np.float32(np.nan), hits.depth).reshape(size)
        share = camera.fx / FOCAL  # Noise is stated in pixels of the full image.
        noise = DepthNoise(
            nearest=0.4, farthest=6.0, lateral_sigma=0.8 * share, disparity_step=0.125 * share
        )
        depth = noise.applied(true, hits.incidence.reshape(size), camera, rng)
        # Where the camera is believed to have been.
        turn = Rotation.from_rotvec(rng.normal(0, 1.0, 3) * noise_m * (0.3, 0.3, 1.0))
        origin = (view_xyz + rng.normal(0, 1.0, 3) * noise_m).astype(np.float32)
        believed = rays @ turn.as_matrix().T.astype(np.float32)
        measured = (believed * depth.reshape(-1, 1) + origin).reshape(*size, 3)
        # A pixel at an edge that measured what is behind belongs to that.
        with np.errstate(invalid="ignore"):
            kind = np.where(np.abs(depth - true) < LEAK_STEP, hits.kind.reshape(size), NOTHING)
        mask = segmentation.mask(kind, depth, measured)
        valid = np.flatnonzero(np.isfinite(depth))
        step = max(1, len(valid) // RAYS_A_VIEW)
        ends = measured.reshape(-1, 3)[valid[rng.integers(step) :: step]]
        return cls(measured[mask], np.broadcast_to(origin, ends.shape), ends)


def _window(
    placed: PlacedObject, view_xyz: NDArray[np.float64], rng: Chance
) -> tuple[PinholeCamera, NDArray[np.float32]]:
    """The part of the camera's image that shows the object, at the resolution that it needs.

    Returns:
        The camera of that part and `R_map_camera`.
    """
    aim = placed.middle + rng.uniform(-0.3, 0.3, 3) * placed.half
    forward = aim - view_xyz
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= max(float(np.linalg.norm(right)), 1e-6)
    R_map_camera = np.column_stack([right, np.cross(forward, right), forward]).astype(np.float32)
    seen = R_map_camera.T @ (placed.middle - view_xyz)
    spread = AROUND * placed.radius / max(seen[2], 0.1)
    low = np.maximum(seen[:2] / max(seen[2], 0.1) - spread, -np.array(HALF_IMAGE))
    high = np.minimum(seen[:2] / max(seen[2], 0.1) + spread, HALF_IMAGE)
    focal = min(ACROSS / (spread * 2 / AROUND), FOCAL)
    width, height = np.maximum(np.ceil((high - low) * focal).astype(int), 8)
    camera = PinholeCamera(
        int(width), int(height), focal, focal, float(-low[0] * focal), float(-low[1] * focal)
    )
    return camera, R_map_camera


def _voxelised(points: NDArray[np.floating]) -> NDArray[np.floating]:
    """One point in each voxel, so that near surfaces weigh no more than far ones."""
    side = max(float(np.ptp(points, axis=0).max()) / VOXELS, 1e-4)
    cells = np.floor((points - points.min(axis=0)) / side).astype(np.int64)
    keys = (cells[:, 0] << 40) | (cells[:, 1] << 20) | cells[:, 2]
    _, first = np.unique(keys, return_index=True)
    return points[first]
