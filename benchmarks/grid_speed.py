"""Speed of grids: native kernels, their NumPy twins, trimesh and a plain histogram, in one run.

    python -m benchmarks.grid_speed [FOLDER]

Each row is repeated for a second, 8 to 200 times. On a busy machine the minimum is more reliable
than the median.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from benchmarks.report import RESULTS, Row, timed, timed_in_turn, write_report
from circumspect.classification import GridSpec
from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, PointCloud, fill_surface
from circumspect.grid import (
    CylindricalGrid,
    RectangularGrid,
    angular_spectrum,
    hits_batch,
    trace_views,
)
from circumspect.grid import numpy_twin as twin

COMMAND = "python -m benchmarks.grid_speed"
ONE_PASS = "inputs of 8 views, one pass"
ONE_BY_ONE = "inputs of 8 views, one by one"
NOTES = """\
points: 100,000 drawn evenly over a chair, float64; grids of 32 x 32 x 32 fitted to them
trimesh points: ops.points_to_indices on the same points, then marked in an array
trimesh mesh: creation.voxelize, method "subdivide", pitch of 1/32 of the same cube
histogramdd: cylindrical coordinates in NumPy, then numpy.histogramdd
views: the eight dithered grids of the shipped classifier, float64, one core; from the cloud to
  its inputs, bounds included; one pass: hits_views; one by one: hits_batch of the points about the
  centre, and bounds as for one pass; both alternate
frame: 640x480, a ball of 0.35 m whose near side is 0.8 m away, a wall at 3.5 m behind it;
  all 307,200 beams, grid of 32 x 32 x 32 and radius 0.45 m about the ball
surface filled: points drawn evenly over a chair, near neighbours joined by triangles, and
  16,384 points sampled on these, as before a sparse cloud is gridded; KDTree: time of
  scipy.spatial.KDTree for the 16 neighbours of each point alone
"""


def rows() -> list[Row]:
    """All measurements, in one run."""
    return [*point_rows(), *view_rows(), *sparse_rows(), *batch_rows(), *frame_rows()]


def point_rows() -> list[Row]:
    """100,000 points into one grid."""
    mesh = make_furniture("chair", 3)
    cloud = mesh.sampled(100_000, 0)
    points = cloud.points_xyz
    grid, cube = CylindricalGrid.fit(cloud), RectangularGrid.fit(cloud)
    single = points.astype(np.float32)
    occupied = grid.hits(points).occupied
    return [
        timed("hits, native, 1 thread", partial(grid.hits, points)),
        timed("hits, native, 2 threads", partial(grid.hits, points, threads=2)),
        timed("hits, native, float32, 1 thread", partial(grid.hits, single)),
        timed("hits, NumPy twin", partial(twin.hits, grid, points)),
        timed("hits, numpy.histogramdd", partial(_histogram, grid, points)),
        timed("cube hits, native, 1 thread", partial(cube.hits, points)),
        timed("cube hits, NumPy twin", partial(twin.hits, cube, points)),
        timed("cube hits, trimesh points", partial(_trimesh_points, cube, points)),
        timed("cube hits, trimesh mesh", _trimesh_mesh(cube, mesh)),
        timed("fit, 100,000 points", partial(CylindricalGrid.fit, PointCloud(points))),
        timed("angular spectrum", partial(angular_spectrum, occupied)),
    ]


def view_rows() -> list[Row]:
    """From 100,000 points to the eight dithered grids of a classifier, and from rays to them."""
    cloud = make_furniture("chair", 3).sampled(100_000, 0)
    input_spec = GridSpec(azimuth_views=8, margin=1.1, dithered=True)
    views = input_spec.all_bounds(input_spec.bounds(cloud))
    origins, ends = _rays(cloud, 20_000)
    none = np.zeros(len(ends), bool)
    with _one_core():
        return [
            *timed_in_turn(
                {
                    ONE_PASS: partial(input_spec.inputs, cloud),
                    ONE_BY_ONE: partial(_one_by_one, input_spec, cloud),
                    "bounds of 100,000 points": partial(input_spec.bounds, cloud),
                },
                seconds=2.0,
            ),
            *timed_in_turn(
                {
                    "trace 20,000 rays, 8 views, one pass": partial(
                        trace_views, views, origins, ends, 1
                    ),
                    "trace 20,000 rays, 8 views, one by one": lambda: [
                        view.trace(origins, ends, none) for view in views
                    ],
                }
            ),
        ]


def ratio(found: Sequence[Row]) -> str:
    """A sentence on the speed-up of one pass over all views."""
    one, several = (
        next(row for row in found if row.name == name) for name in (ONE_PASS, ONE_BY_ONE)
    )
    return (
        f"\nOne pass over all views is {several.minimum / one.minimum:.1f} times as fast as one by "
        f"one by the minima, {several.median / one.median:.1f} times by the medians.\n"
    )


def sparse_rows() -> list[Row]:
    """Clouds with holes at the grid's resolution."""
    mesh, found = make_furniture("chair", 3), []
    for count in (1024, 16_384):
        cloud = mesh.sampled(count, 0)
        found += [
            timed(f"{count:,} points, surface filled", partial(fill_surface, cloud)),
            timed(f"{count:,} points, KDTree", partial(_neighbours, cloud.points_xyz)),
        ]
    return found


def batch_rows() -> list[Row]:
    """64 clouds of 10,000 points."""
    clouds = [make_furniture("table", seed).sampled(10_000, seed).points_xyz for seed in range(64)]
    grids = [CylindricalGrid.fit(PointCloud(cloud)) for cloud in clouds]
    return [
        timed("64 x 10,000 points, native, 1 thread", partial(hits_batch, grids, clouds, 1)),
        timed("64 x 10,000 points, native, 2 threads", partial(hits_batch, grids, clouds, 2)),
        timed("64 x 10,000 points, NumPy twin", partial(twin.hits_batch, grids, clouds)),
    ]


def frame_rows() -> list[Row]:
    """All beams of a 640x480 frame."""
    origin, ends = frame()
    bounds: dict[str, Any] = {"centre_xyz": (1.15, 0.0, 0.0)}
    grid = CylindricalGrid(radius=0.45, half_height=0.45, **bounds)
    cube = RectangularGrid(half_width=0.45, **bounds)
    few = ends[::64]
    return [
        timed("trace a frame, native, 1 thread", partial(grid.trace, origin, ends)),
        timed("trace a frame, native, 2 threads", partial(grid.trace, origin, ends, threads=2)),
        timed("cube trace a frame, native, 1 thread", partial(cube.trace, origin, ends)),
        timed("trace 1/64 of it, native, 1 thread", partial(grid.trace, origin, few)),
        timed("trace 1/64 of it, NumPy twin", partial(twin.trace, grid, origin, few)),
    ]


def frame() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3,) origin and (307200, 3) ends [m] of a frame; x forward, z up."""
    optical = PinholeCamera.xtion().rays_xyz.reshape(-1, 3)
    rays = np.stack([optical[:, 2], -optical[:, 0], -optical[:, 1]], axis=1)
    # |t ray - centre| = 0.35 with the centre 1.15 m ahead.
    a, b, c = (rays**2).sum(axis=1), 1.15 * rays[:, 0], 1.15**2 - 0.35**2
    inside = b * b - a * c
    t = np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0))) / a, 3.5)
    return np.zeros(3), t[:, None] * rays


def _one_by_one(input_spec: GridSpec, cloud: PointCloud) -> NDArray[np.uint8]:
    frame = input_spec.bounds(cloud)
    points = cloud.points_xyz - np.asarray(frame.centre_xyz)
    views = input_spec.all_bounds(frame.recentred())
    return hits_batch(views, [points] * len(views), threads=1)


def _rays(cloud: PointCloud, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(count, 3) origins on a circle about an object and ends on it [m]."""
    azimuth = np.linspace(0.0, math.tau, count, endpoint=False)
    circle = np.stack([np.cos(azimuth), np.sin(azimuth), np.full(count, 0.5)], axis=1)
    return 2.0 * circle, cloud.points_xyz[:: len(cloud) // count][:count]


@contextmanager
def _one_core() -> Iterator[None]:
    """Keeps this process on one core if the system supports it."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


def _neighbours(points: NDArray[np.float64]) -> object:
    return KDTree(points).query(points, 17)


def _histogram(grid: CylindricalGrid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    x, y, z = (points - grid.centre_xyz).T
    values = np.stack([np.hypot(x, y), np.arctan2(y, x) % math.tau, z], axis=1)
    limits = ((0, grid.radius), (0, math.tau), (-grid.half_height, grid.half_height))
    return np.histogramdd(values, bins=grid.shape, range=limits)[0] > 0


def _trimesh_points(cube: RectangularGrid, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    from trimesh.voxel.ops import points_to_indices

    pitch = 2 * cube.half_width / cube.shape[0]
    origin = np.array(cube.centre_xyz) - cube.half_width + pitch / 2
    occupied = np.zeros(cube.shape, bool)
    cells = np.clip(points_to_indices(points, pitch, origin), 0, np.array(cube.shape) - 1)
    occupied[tuple(cells.T)] = True
    return occupied


def _trimesh_mesh(cube: RectangularGrid, mesh: Any) -> Callable[[], object]:
    import trimesh

    other = trimesh.Trimesh(mesh.vertices_xyz, mesh.faces, process=False)
    pitch = 2 * cube.half_width / cube.shape[0]
    return partial(trimesh.voxel.creation.voxelize, other, pitch)


def main() -> None:
    """Measure, print, and write `grid_speed.md` and `grid_speed.json` into a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=RESULTS)
    folder: Path = parser.parse_args().folder
    found = rows()
    write_report("grid_speed", COMMAND, found, NOTES + ratio(found), folder)


if __name__ == "__main__":
    main()
