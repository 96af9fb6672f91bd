"""Other objects from one: mirrored, stretched, shifted, seen in part, with holes.

`AugmentedClouds` turns them where a training asks for a random yaw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.damage import damaged
from circumspect.datasets.partial_view import PartialView
from circumspect.errors import InputError

FLOOR_MARGIN = 0.06
"""Up to this height above the floor a scan may miss the object, in units of its scale."""
FEWEST = 100
"""A scan with fewer samples is no scan."""


@dataclass(frozen=True)
class Augmentation:
    """Ranges of the random changes; lengths are in units of the object's scale.

    Rotation about the vertical is left out on purpose: networks are trained at 0° only, except the
    rows of a comparison that are labelled otherwise (`TrainingSettings.random_yaw`).

    Attributes:
        mirror: Chance to swap left and right (x to -x).
        stretch: Each axis is scaled by e^u, u uniform in ± this.
        jitter: Largest standard deviation of noise on each point.
        shift: Largest displacement of the centre, in the plane and along the axis.
        scale: Range of the grid's size in units of the object's: in training it is drawn, and takes
            the place of the recipe's margin.
        thin: Half of the objects keep a share of their samples, drawn from this … 1.
        holes: Chance that up to four balls are cut out.
        hole_radius: Range of their radius.
        partial: Chance that only what a camera sees from an arc around the object is kept, and a
            little is missing above the floor: what a robot's scan looks like.
        damage: Chance that a large part is missing, points float about or the axis leans.
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
        """Objects as they are, in a grid that is this many times as large as the smallest."""
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
        """Change an object and sample its surface anew.

        Args:
            points_xyz: (n, 3) evenly spread points of the object.
            triangles: (t, 3) indices: triangles between near points; one sample is drawn on each.
            rng: Source of all chance.

        Returns:
            (m, 3) points in units of the object's scale: those within radius 1 of the axis and
            within ±1 of the centre's height fall into the grid.
        """
        vertices = self._roughened(_normalised(self._deformed(points_xyz, rng)), rng)
        samples = np.concatenate([vertices, self._between(vertices, triangles, rng)])
        if rng.random() < self.partial:
            samples = _scanned(samples, rng)
        # No coin is tossed where none is asked for: older runs stay as they are.
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
        """Of another size, slightly off the centre."""
        angle, reach = rng.uniform(0, 2 * np.pi), self.shift * np.sqrt(rng.random())
        height = rng.uniform(-self.shift, self.shift)
        offset = np.array([reach * np.cos(angle), reach * np.sin(angle), height], np.float32)
        size = np.float32(rng.uniform(*self.scale))
        return np.asarray(samples / size + offset, np.float32)

    def _covered(
        self, samples: NDArray[np.float32], vertices: int, rng: np.random.Generator
    ) -> NDArray[np.bool_]:
        """(n,) what is left between the holes; all where nothing would be."""
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
    """As for the grid: the centre at the origin, isotropically scaled to reach 1."""
    centred = points_xyz - points_xyz.mean(axis=0)
    radius = np.hypot(centred[:, 0], centred[:, 1]).max()
    extent = max(radius, np.abs(centred[:, 2]).max(), np.finfo(np.float32).tiny)
    return centred / np.float32(extent)


def _scanned(samples: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """What a scan keeps: the seen, less what the floor's margin takes, normalised anew."""
    floor = samples[:, 2].min() + rng.uniform(0.0, FLOOR_MARGIN)
    kept = PartialView.drawn(rng).sees(samples) & (samples[:, 2] > floor)
    return _normalised(samples[kept]) if np.count_nonzero(kept) > FEWEST else samples
