"""How good are surfaces made of 1,024 points? `python benchmarks/point_surfaces.py`.

Procedural furniture is sampled as the point packs are, rebuilt, and compared with itself in
depth images from eight sides.
"""

from __future__ import annotations

import argparse

import numpy as np

from circumspect.datasets.farthest_points import evenly_sampled
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.simulation import Orbit, RayCaster, Scene, Surface, surface_from_points

VARIANTS = 3
CAMERA = PinholeCamera(160, 120, 142.6, 142.6, 79.5, 59.5)
CLEARLY = 0.05
"""Depths that differ by more lie on different surfaces [m]."""


def main() -> None:
    """Print one line a category and the mean."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    head = ("", "through", "missed", "before", "median [mm]", "90 % [mm]")
    print("{:12} {:>8} {:>8} {:>8} {:>12} {:>12}".format(*head))
    rows = []
    for category in CATEGORIES:
        rows.append(np.mean([compared(category, seed) for seed in range(VARIANTS)], axis=0))
        tell(category, rows[-1])
    tell("mean", np.mean(rows, axis=0))


def tell(name: str, row: np.ndarray) -> None:
    """Print a line."""
    print("{:12} {:8.3f} {:8.3f} {:8.3f} {:12.1f} {:12.1f}".format(name, *row))


def compared(category: str, seed: int) -> list[float]:
    """Shares of the object's pixels and errors [mm] of one piece."""
    true = make_furniture(category, seed)
    points = evenly_sampled(true, seed).astype(np.float64)
    rebuilt = surface_from_points(points, category)
    # To the true piece's own size and place instead of the category's.
    scale = np.ptp(true.vertices_xyz, axis=0).max() / np.ptp(rebuilt.vertices_xyz, axis=0).max()
    rebuilt = TriangleMesh(rebuilt.vertices_xyz * scale, rebuilt.faces)
    a, b = depths(true, true), depths(rebuilt, true)
    hit, again = np.isfinite(a), np.isfinite(b)
    both = hit & again
    difference = np.abs(b - a)[both] * 1000
    missed = (hit & ~again).sum()
    through = missed + (b - a > CLEARLY)[both].sum()
    before = (again & ~hit).sum() + (a - b > CLEARLY)[both].sum()
    shares = [count / hit.sum() for count in (through, missed, before)]
    return [*shares, float(np.median(difference)), float(np.percentile(difference, 90))]


def depths(mesh: TriangleMesh, circled: TriangleMesh) -> np.ndarray:
    """(8, height, width) of a mesh without a floor, from the circle round another."""
    orbit = Orbit.around(circled, PinholeCamera.xtion())
    caster = RayCaster(Scene((Surface("object", mesh),)))
    stations = (orbit.station(k * np.pi / 4 + 0.2) for k in range(8))
    return np.stack([caster.view(CAMERA, station.T_map_camera).depth for station in stations])


if __name__ == "__main__":
    main()
