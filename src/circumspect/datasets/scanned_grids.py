"""Simulated scans of training objects as network inputs, made once and cached."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import WIDTH, grid_context
from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import ScanAugmentation, SimulatedScan
from circumspect.datasets.training_objects import TrainingObjects
from circumspect.errors import InputError
from circumspect.geometry.npy_stream import read_arrays
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.storage import atomic_open

FORMAT = 1
CHUNK = 32
"""Objects a file: what an interruption loses."""
SIZES = (0.98, 1.15)
"""Of a grid, in units of the smallest one round the points."""
SHIFT = 0.04
"""Largest displacement of its centre, in units of its radius."""
_KINDS = {"grids": "u", "context": "f", "coverage": "f"}


@dataclass(frozen=True, eq=False)
class ScannedGrids:
    """Inputs from n objects, r scans each.

    Attributes:
        grids: (n, r, bytes) uint8: occupied cells, then free cells, as packed bits.
        context: (n, r, 6) float32, see `grid_context`.
        coverage: (n, r) float32 share of the azimuth seen, NaN for complete surfaces.
        shape: Cells along (radius, azimuth, height).
    """

    grids: NDArray[np.uint8]
    context: NDArray[np.float32]
    coverage: NDArray[np.float32]
    shape: tuple[int, int, int]

    def states(self, objects: NDArray[np.int64], scans: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(b, *shape) uint8 states of chosen scans: `UNKNOWN`, `FREE` or `OCCUPIED`."""
        cells = int(np.prod(self.shape))
        bits = np.unpackbits(self.grids[objects, scans], axis=1, count=2 * cells)
        occupied, free = bits.reshape(-1, 2, *self.shape).transpose(1, 0, 2, 3, 4)
        return (occupied << 1) | (free & ~occupied)


def scanned_grids(
    objects: TrainingObjects,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    shape: tuple[int, int, int] = (32, 32, 32),
    folder: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> ScannedGrids:
    """Scan every object several times; a part that is cached is not made again.

    Args:
        objects: What is scanned.
        augmentation: How.
        scans: Of each object.
        seed: Of all chance; a scan depends on it, the object's name and its number alone.
        shape: Cells along (radius, azimuth, height).
        folder: Of the cache; None means the user's cache folder.
        progress: Called with (done, all) objects.
        workers: Processes; None means one a core.

    Raises:
        MissingExtraError: Embree is not installed.
        OutputError: The cache can not be written.
    """
    folder = cache_folder("scans") if folder is None else folder
    key = {
        "format": FORMAT, "objects": objects.digest, "augmentation": asdict(augmentation),
        "scans": scans, "seed": seed, "shape": shape, "grid": [*SIZES, SHIFT],
    }  # fmt: skip
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:32]
    starts = range(0, len(objects), CHUNK)
    paths = [folder / f"{name}-{start}.npz" for start in starts]
    sizes = [(min(CHUNK, len(objects) - start), scans) for start in starts]
    parts = [_read(path, size, shape) for path, size in zip(paths, sizes, strict=True)]
    missing = [number for number, part in enumerate(parts) if part is None]
    done = sum(size[0] for size, part in zip(sizes, parts, strict=True) if part is not None)
    # Spawned: a fork would share the locks of threads that it does not have.
    context = multiprocessing.get_context("spawn")
    if missing:
        with ProcessPoolExecutor(
            workers or os.cpu_count(), context, _begin_worker, (objects,)
        ) as pool:
            jobs = {
                pool.submit(
                    _scanned_chunk, starts[number], augmentation, scans, seed, shape
                ): number
                for number in missing
            }
            for job in as_completed(jobs):
                number = jobs[job]
                parts[number] = made = job.result()
                _write(paths[number], made)
                done += sizes[number][0]
                if progress:
                    progress(done, len(objects))
    joined = [np.concatenate([part[k] for part in parts if part]) for k in _KINDS]
    return ScannedGrids(joined[0], joined[1], joined[2], shape)


_SCANNED: list[TrainingObjects] = []
"""What a worker scans: given once, not with every job."""


def _begin_worker(objects: TrainingObjects) -> None:
    _SCANNED[:] = [objects]


def _scanned_chunk(
    start: int,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    shape: tuple[int, int, int],
) -> dict[str, NDArray[Any]]:
    objects = _SCANNED[0]
    chosen = range(start, min(start + CHUNK, len(objects)))
    cells = 2 * int(np.prod(shape))
    grids = np.zeros((len(chosen), scans, -(-cells // 8)), np.uint8)
    context = np.zeros((len(chosen), scans, WIDTH), np.float32)
    coverage = np.full((len(chosen), scans), np.nan, np.float32)
    for row, index in enumerate(chosen):
        caster, name = ObjectCaster(objects.mesh(index)), objects.names[index]
        for scan in range(scans):
            rng = chance_of(seed, str(name), scan)
            found = augmentation.scan(caster, rng)
            if not len(found.points_xyz):
                continue  # An empty grid: nothing of it was seen.
            grid = gridded(found, shape, rng)
            occupied, free = grid.occupied, grid.free
            grids[row, scan] = np.packbits(np.stack([occupied, free]))
            bounds = grid.grid
            assert isinstance(bounds, CylindricalGrid)
            visible = len(found.ends_xyz) > 0
            context[row, scan] = grid_context(
                occupied, (bounds.radius, bounds.half_height), visible=visible
            )
            if visible:
                coverage[row, scan] = azimuth_coverage(found.views_xyz, bounds.centre_xyz)
    return {"grids": grids, "context": context, "coverage": coverage}


def chance_of(seed: int, name: str, scan: int) -> np.random.Generator:
    """Chance that depends on a seed, an object and the number of its scan alone."""
    digest = hashlib.sha256(f"{seed}/{name}/{scan}".encode(errors="surrogatepass")).digest()
    return np.random.default_rng(np.frombuffer(digest, np.uint32))


def gridded(
    scan: SimulatedScan, shape: tuple[int, int, int], rng: np.random.Generator
) -> OccupancyGrid:
    """A scan in a grid of slightly random size and place, ray traced where it has rays."""
    points = scan.points_xyz
    centre = points.mean(axis=0)
    about = points - centre
    radius = max(float(np.hypot(about[:, 0], about[:, 1]).max()), float(np.abs(about[:, 2]).max()))
    radius = max(radius, 1e-3) * rng.uniform(*SIZES)
    x, y, z = (centre + rng.uniform(-SHIFT, SHIFT, 3) * radius).tolist()
    grid = CylindricalGrid(shape, radius, radius, (x, y, z))
    occupied = grid.hits(points)
    if not len(scan.ends_xyz):
        return occupied
    passed = np.zeros(len(scan.ends_xyz), bool)
    traced = grid.trace(scan.origins_xyz, scan.ends_xyz, passed)
    return occupied.merged(traced)


def azimuth_coverage(
    views_xyz: NDArray[np.floating], centre_xyz: tuple[float, float, float]
) -> float:
    """Share of the directions about an axis that are within 45° of some view."""
    offset = views_xyz[:, :2] - np.asarray(centre_xyz[:2])
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    directions = np.arange(72) * (2 * np.pi / 72)
    apart = np.abs((directions[:, None] - bearings + np.pi) % (2 * np.pi) - np.pi)
    return float((apart <= np.pi / 4).any(axis=1).mean())


def _read(
    path: Path, size: tuple[int, int], shape: tuple[int, int, int]
) -> dict[str, NDArray[Any]] | None:
    try:
        found = read_arrays(path, _KINDS)
    except InputError:
        return None
    wide = -(-2 * int(np.prod(shape)) // 8)
    fits = found["grids"].shape == (*size, wide) and found["context"].shape == (*size, WIDTH)
    return found if fits else None


def _write(path: Path, part: dict[str, NDArray[Any]]) -> None:
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream, grids=part["grids"], context=part["context"], coverage=part["coverage"]
        )
