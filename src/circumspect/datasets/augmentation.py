"""Augmentation of training objects: mirroring, stretching, shifts, partial views, holes.

`AugmentedClouds` also rotates objects if a training uses a random yaw.

The corruptions for evaluation are in `corruption`; they differ in kind, amount and probability.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.errors import InputError

FLOOR_MARGIN = 0.06
"""Maximum height above the floor of the missing strip of a scan [object scales]."""
MIN_SAMPLES = 100
"""Smallest number of samples in a scan."""
PIXELS = 32
"""Side of the depth images that decide occlusion [px]."""
THICKNESS = 0.05
"""Points this far behind the nearest one of their pixel are hidden [object scales]."""
Samples = NDArray[np.float32]
MISSING = (0.1, 0.5)
"""Fraction of the samples that a cut or holes remove."""
MAX_HOLES = 4
MAX_STRAY_SHARE = 0.01
"""Fraction of stray points per sample; a filled cloud has several samples per measured point."""
MAX_LEAN_DEG = 10.0


@dataclass(frozen=True)
class PartialView:
    """A distant camera on an arc around the origin.

    Attributes:
        start: Heading of the first view [rad], counter-clockwise from +x.
        arc: Angle of the arc [rad]; at least 2π is a full orbit.
        elevation: Angle above the horizon [rad].
        looks: Number of views.
    """

    start: float
    arc: float
    elevation: float
    looks: int = 8

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> PartialView:
        """Draw an arc from a quarter orbit to a full one, with one view every 45°."""
        arc = float(rng.uniform(np.pi / 2, 2.5 * np.pi))
        elevation = float(rng.uniform(np.radians(8), np.radians(45)))
        looks = max(2, int(np.ceil(min(arc, 2 * np.pi) / (np.pi / 4))))
        return cls(float(rng.uniform(0, 2 * np.pi)), arc, elevation, looks)

    def sees(self, points_xyz: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Which points are visible in any of the views.

        Depth images of `PIXELS` x `PIXELS` by parallel projection have the resolution of a grid
        and need neither triangles nor a ray caster.

        Args:
            points_xyz: (n, 3) dense samples of the surface, in units of the object's scale.

        Returns:
            (n,) bool.
        """
        whole = self.arc >= 2 * np.pi
        arc = 2 * np.pi if whole else self.arc
        steps = np.arange(self.looks) / (self.looks if whole else max(self.looks - 1, 1))
        seen = np.zeros(len(points_xyz), bool)
        for heading in self.start + arc * steps:
            seen |= _nearest(points_xyz, float(heading), self.elevation)
        return seen


def _nearest(
    points_xyz: NDArray[np.floating], heading: float, elevation: float
) -> NDArray[np.bool_]:
    """(n,) points that are visible from one direction."""
    level, rise = np.cos(elevation), np.sin(elevation)
    towards = np.array([level * np.cos(heading), level * np.sin(heading), rise])
    across = np.array([-np.sin(heading), np.cos(heading), 0.0])
    axes = np.column_stack([across, np.cross(towards, across), towards])
    u, v, depth = (points_xyz @ axes.astype(points_xyz.dtype)).T
    u, v = u - u.min(), v - v.min()
    side = max(float(u.max()), float(v.max()), 1e-9) / (PIXELS - 1)
    # With a border of one pixel, each pixel has four neighbours.
    width = PIXELS + 2
    pixel = ((u / side).astype(np.intp) + 1) * width + (v / side).astype(np.intp) + 1
    front = np.full(width * width, -np.inf, depth.dtype)
    np.maximum.at(front, pixel, depth)
    image = front.reshape(width, width)
    # A pixel without a sample is a gap between samples, not a hole, if three of its four neighbours
    # have one.
    around = [image[:-2, 1:-1], image[2:, 1:-1], image[1:-1, :-2], image[1:-1, 2:]]
    image[1:-1, 1:-1] = np.maximum(image[1:-1, 1:-1], np.sort(around, axis=0)[1])
    return depth >= front[pixel] - THICKNESS


@dataclass(frozen=True)
class Augmentation:
    """Ranges of the random changes; lengths are in units of the object's scale.

    Rotation about the vertical is not included: networks are trained at 0° only, unless
    `TrainingSettings.random_yaw` is set.

    Attributes:
        mirror: Probability of swapping left and right (x to -x).
        stretch: Each axis is scaled by e^u, u uniform in ± this.
        jitter: Largest standard deviation of noise on each point.
        shift: Largest displacement of the centre, in the plane and along the axis.
        scale: Range of the grid's size in units of the object's; in training it is drawn and
            replaces the margin of the input specification.
        thin: Half of the objects keep a fraction of their samples, drawn from this … 1.
        holes: Probability of up to four spherical holes.
        hole_radius: Range of the holes' radius.
        partial: Probability of keeping only the part that a camera sees from an arc around the
            object, without a strip above the floor, as in a robot's scan.
        damage: Probability of a large missing part, stray points or a leaning axis.
    """

    mirror: float = 0.5
    stretch: float = 0.06
    jitter: float = 0.01
    shift: float = 0.04
    scale: tuple[float, float] = (0.95, 1.15)
    thin: float = 0.3
    holes: float = 0.5
    hole_radius: tuple[float, float] = (0.05, 0.25)
    partial: float = 0.0
    damage: float = 0.0

    @classmethod
    def none(cls, margin: float = 1.0) -> Augmentation:
        """No changes; the grid has `margin` times the smallest size."""
        scale = (margin, margin)
        return cls(mirror=0.0, stretch=0.0, jitter=0.0, shift=0.0, scale=scale, thin=1.0, holes=0.0)

    def __post_init__(self) -> None:
        for name in ("mirror", "stretch", "jitter", "shift", "thin", "holes", "partial", "damage"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"{name} must lie in 0 … 1, not {getattr(self, name)}")

    def apply(
        self,
        points_xyz: NDArray[np.float32],
        triangles: NDArray[np.integer],
        rng: np.random.Generator,
    ) -> NDArray[np.float32]:
        """Change an object and sample its surface again.

        Args:
            points_xyz: (n, 3) evenly spread points of the object.
            triangles: (t, 3) indices of near points; one sample is drawn on each triangle.
            rng: Random generator.

        Returns:
            (m, 3) points in units of the object's scale; the grid contains those within radius 1 of
            the axis and within ±1 of the centre's height.
        """
        vertices = self._roughened(_normalised(self._deformed(points_xyz, rng)), rng)
        samples = np.concatenate([vertices, self._between(vertices, triangles, rng)])
        if rng.random() < self.partial:
            samples = _scanned(samples, rng)
        # A probability of 0 draws nothing, so that older runs stay reproducible.
        if self.damage and rng.random() < self.damage:
            samples = _normalised(damaged(samples, rng))
        samples = self._placed(samples, rng)
        return samples.compress(self._covered(samples, len(vertices), rng), axis=0)

    def _deformed(
        self, points_xyz: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        factors = np.exp(rng.uniform(-self.stretch, self.stretch, 3)).astype(np.float32)
        if rng.random() < self.mirror:
            factors[0] = -factors[0]
        return points_xyz * factors

    def _roughened(
        self, vertices: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        noise = rng.standard_normal(vertices.shape, np.float32)
        noise *= np.float32(rng.uniform(0, self.jitter))
        return vertices + noise

    def _placed(
        self, samples: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """The samples, scaled and shifted."""
        angle, reach = rng.uniform(0, 2 * np.pi), self.shift * np.sqrt(rng.random())
        height = rng.uniform(-self.shift, self.shift)
        offset = np.array([reach * np.cos(angle), reach * np.sin(angle), height], np.float32)
        size = np.float32(rng.uniform(*self.scale))
        return np.asarray(samples / size + offset, np.float32)

    def _covered(
        self, samples: NDArray[np.float32], vertices: int, rng: np.random.Generator
    ) -> NDArray[np.bool_]:
        """(n,) points outside the holes; all points if none would remain."""
        keep = np.ones(len(samples), bool)
        if rng.random() < 0.5:
            keep &= rng.random(len(samples)) < rng.uniform(self.thin, 1.0)
        if rng.random() < self.holes:
            centres = samples[rng.integers(min(vertices, len(samples)), size=rng.integers(1, 5))]
            radius = rng.uniform(*self.hole_radius)
            for centre in centres:
                keep &= ((samples - centre) ** 2).sum(axis=1) > radius**2
        return keep if keep.any() else np.ones(len(samples), bool)

    def _between(
        self,
        vertices: NDArray[np.float32],
        triangles: NDArray[np.integer],
        rng: np.random.Generator,
    ) -> NDArray[np.float32]:
        a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
        u, v = rng.random((2, len(triangles), 1), np.float32)
        fold = u + v > 1
        u, v = np.where(fold, 1 - u, u), np.where(fold, 1 - v, v)
        return a + u * (b - a) + v * (c - a)


def _normalised(points_xyz: NDArray[np.float32]) -> NDArray[np.float32]:
    """Normalised for the grid: centre at the origin, isotropically scaled to reach 1."""
    centred = points_xyz - points_xyz.mean(axis=0)
    radius = np.hypot(centred[:, 0], centred[:, 1]).max()
    extent = max(radius, np.abs(centred[:, 2]).max(), np.finfo(np.float32).tiny)
    return centred / np.float32(extent)


def _scanned(samples: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """The visible part of a scan without the strip above the floor, normalised again."""
    floor = samples[:, 2].min() + rng.uniform(0.0, FLOOR_MARGIN)
    kept = PartialView.drawn(rng).sees(samples) & (samples[:, 2] > floor)
    return _normalised(samples[kept]) if np.count_nonzero(kept) > MIN_SAMPLES else samples


def damaged(samples: Samples, rng: np.random.Generator) -> Samples:
    """Damage an object's samples in one of four ways, all equally likely.

    Args:
        samples: (n, 3) in units of the scale, the centre at the origin, z up; n at least 1.
        rng: Random generator.

    Returns:
        (m, 3) with m at least 1, neither centred nor scaled again.
    """
    damage = (_cut, _holed, _with_strays, _leaning)[rng.integers(4)]
    return damage(samples, rng)


def _cut(samples: Samples, rng: np.random.Generator) -> Samples:
    """Remove everything beyond a random plane."""
    direction = rng.normal(size=3)
    along = samples @ (direction / np.linalg.norm(direction)).astype(np.float32)
    return samples[along <= np.quantile(along, 1 - rng.uniform(*MISSING))]


def _holed(samples: Samples, rng: np.random.Generator) -> Samples:
    """Remove balls of equal numbers of samples."""
    holes = int(rng.integers(1, MAX_HOLES + 1))
    size = int(len(samples) * rng.uniform(*MISSING) / holes)
    for _ in range(holes):
        away = ((samples - samples[rng.integers(len(samples))]) ** 2).sum(axis=1)
        # Keep the order: evenly spread points come first.
        samples = samples[np.sort(np.argsort(away)[size:])]
    return samples


def _with_strays(samples: Samples, rng: np.random.Generator) -> Samples:
    """Add stray points in the ball around the object."""
    count = round(len(samples) * rng.uniform(0, MAX_STRAY_SHARE))
    radius = np.linalg.norm(samples, axis=1).max()
    directions = rng.normal(size=(count, 3))
    away = radius * np.cbrt(rng.random((count, 1)))
    strays = away * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([samples, strays.astype(np.float32)])


def _leaning(samples: Samples, rng: np.random.Generator) -> Samples:
    """Rotate about a horizontal axis; the heading is kept."""
    heading, lean = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, MAX_LEAN_DEG))
    turn = Rotation.from_rotvec(lean * np.array([np.cos(heading), np.sin(heading), 0.0]))
    return samples @ turn.as_matrix().T.astype(np.float32)
