"""Other objects from one: mirrored, stretched, shifted, with holes; never turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError


@dataclass(frozen=True)
class Augmentation:
    """Ranges of the random changes; lengths are in units of the object's scale.

    Rotation about the vertical is left out on purpose: networks are trained at 0° only.

    Attributes:
        mirror: Chance to swap left and right (x to -x).
        stretch: Each axis is scaled by e^u, u uniform in ± this.
        jitter: Largest standard deviation of noise on each point.
        shift: Largest displacement of the centre, in the plane and along the axis.
        scale: Range of the object's size against the grid.
        thin: Half of the objects keep a share of their samples, drawn from this … 1.
        holes: Chance that up to four balls are cut out.
        hole_radius: Range of their radius.
    """

    mirror: float = 0.5
    stretch: float = 0.06
    jitter: float = 0.01
    shift: float = 0.04
    scale: tuple[float, float] = (0.95, 1.15)
    thin: float = 0.3
    holes: float = 0.5
    hole_radius: tuple[float, float] = (0.05, 0.25)

    def __post_init__(self) -> None:
        for name in ("mirror", "stretch", "jitter", "shift", "thin", "holes"):
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
        vertices = self._placed(self._deformed(points_xyz, rng), rng)
        samples = np.concatenate([vertices, self._between(vertices, triangles, rng)])
        keep = np.ones(len(samples), bool)
        if rng.random() < 0.5:
            keep &= rng.random(len(samples)) < rng.uniform(self.thin, 1.0)
        if rng.random() < self.holes:
            centres = vertices[rng.integers(len(vertices), size=rng.integers(1, 5))]
            radius = rng.uniform(*self.hole_radius)
            for centre in centres:
                keep &= ((samples - centre) ** 2).sum(axis=1) > radius**2
        return samples[keep] if keep.any() else samples

    def _deformed(
        self, points_xyz: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        factors = np.exp(rng.uniform(-self.stretch, self.stretch, 3)).astype(np.float32)
        if rng.random() < self.mirror:
            factors[0] = -factors[0]
        return points_xyz * factors

    def _placed(
        self, points_xyz: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """Normalised as for the grid (centre, isotropic scale), then slightly off."""
        vertices = points_xyz - points_xyz.mean(axis=0)
        extent = max(np.hypot(vertices[:, 0], vertices[:, 1]).max(), np.abs(vertices[:, 2]).max())
        vertices /= np.float32(max(extent, np.finfo(np.float32).tiny) * rng.uniform(*self.scale))
        angle, reach = rng.uniform(0, 2 * np.pi), self.shift * np.sqrt(rng.random())
        height = rng.uniform(-self.shift, self.shift)
        vertices += np.array([reach * np.cos(angle), reach * np.sin(angle), height], np.float32)
        noise = rng.standard_normal(vertices.shape, np.float32)
        return vertices + noise * np.float32(rng.uniform(0, self.jitter))

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
