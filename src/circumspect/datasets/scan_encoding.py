"""A simulated scan as what a network is shown, in few bytes.

| network takes | stored |
|---|---|
| a cylindrical grid | occupied cells and free cells, a bit each |
| a rectangular grid | occupied cells, a bit each |
| points | as many as it takes, in half precision |
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe, InputRecipe, PointsRecipe
from circumspect.classification.context import WIDTH, grid_context
from circumspect.datasets.scan_augmentation import SimulatedScan
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid

SIZES = (0.98, 1.15)
"""Of a grid, in units of the smallest one round the points."""
SHIFT = 0.04
"""Largest displacement of its centre, in units of its radius."""


def width_of(recipe: InputRecipe) -> int:
    """Bytes of a scan."""
    if isinstance(recipe, PointsRecipe):
        return recipe.count * 3 * 2
    assert isinstance(recipe, GridRecipe)
    return -(-_layers(recipe) * int(np.prod(recipe.shape)) // 8)


def encoded(
    scan: SimulatedScan, recipe: InputRecipe, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float32], CylindricalGrid]:
    """A scan in a grid of slightly random size and place.

    Args:
        scan: Of at least one point.
        recipe: What the network is shown.
        rng: Draws size and place.

    Returns:
        The bytes, the context (6,), and the cylinder.
    """
    cylinder = drawn_cylinder(scan, rng)
    visible = len(scan.ends_xyz) > 0
    if isinstance(recipe, PointsRecipe):
        about = (scan.points_xyz - np.asarray(cylinder.centre_xyz, np.float32)) / cylinder.radius
        shown = recipe.of_samples(about, rng).astype(np.float16)
        return np.frombuffer(shown.tobytes(), np.uint8), np.zeros(WIDTH, np.float32), cylinder
    assert isinstance(recipe, GridRecipe)
    if recipe.kind == "rectangular":
        cube = RectangularGrid(recipe.shape, cylinder.radius, cylinder.centre_xyz)
        occupied = cube.hits(scan.points_xyz).occupied
        return np.packbits(occupied), np.zeros(WIDTH, np.float32), cylinder
    grid = traced(scan, CylindricalGrid(
        recipe.shape, cylinder.radius, cylinder.half_height, cylinder.centre_xyz
    ))  # fmt: skip
    context = grid_context(grid.occupied, (cylinder.radius, cylinder.half_height), visible=visible)
    return np.packbits(np.stack([grid.occupied, grid.free])), context, cylinder


def decoded(packed: NDArray[np.uint8], recipe: InputRecipe) -> NDArray[Any]:
    """What a network is shown: (b, *input_shape), states of a cylindrical grid."""
    if isinstance(recipe, PointsRecipe):
        rows = np.ascontiguousarray(packed).view(np.float16)
        return rows.reshape(-1, recipe.count, 3).astype(np.float32)
    assert isinstance(recipe, GridRecipe)
    layers, cells = _layers(recipe), int(np.prod(recipe.shape))
    bits = np.unpackbits(packed, axis=1, count=layers * cells)
    found = bits.reshape(-1, layers, *recipe.shape)
    if layers == 1:
        return found
    occupied, free = found[:, :1], found[:, 1:]
    return (occupied << 1) | (free & ~occupied) if recipe.visibility else occupied


def drawn_cylinder(scan: SimulatedScan, rng: np.random.Generator) -> CylindricalGrid:
    """The cylinder round a scan's points, of another size and a little aside."""
    points = scan.points_xyz
    centre = points.mean(axis=0)
    about = points - centre
    radius = max(float(np.hypot(about[:, 0], about[:, 1]).max()), float(np.abs(about[:, 2]).max()))
    radius = max(radius, 1e-3) * rng.uniform(*SIZES)
    x, y, z = (centre + rng.uniform(-SHIFT, SHIFT, 3) * radius).tolist()
    return CylindricalGrid(radius=radius, half_height=radius, centre_xyz=(x, y, z))


def traced(scan: SimulatedScan, grid: CylindricalGrid) -> OccupancyGrid:
    """A scan in a grid, ray traced where it has rays."""
    occupied = grid.hits(scan.points_xyz)
    if not len(scan.ends_xyz):
        return occupied
    passed = np.zeros(len(scan.ends_xyz), bool)
    return occupied.merged(grid.trace(scan.origins_xyz, scan.ends_xyz, passed))


def _layers(recipe: GridRecipe) -> int:
    """Bits of a cell: free cells are kept where rays are traced."""
    return 2 if recipe.kind == "cylindrical" else 1
