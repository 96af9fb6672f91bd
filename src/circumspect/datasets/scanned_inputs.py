"""Simulated scans of training objects as cached network inputs.

| input of the network | stored |
|---|---|
| cylindrical grid | occupied cells and free cells, one bit each |
| rectangular grid | occupied cells, one bit each |
| points | all points, in half precision |
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.classification.context import WIDTH, grid_context
from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import ScanAugmentation, TrainingScan
from circumspect.datasets.worker_pool import worker_pool
from circumspect.errors import InputError
from circumspect.geometry.formats.npy_stream import read_arrays
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid
from circumspect.storage import atomic_open

FORMAT = 2
CHUNK = 32
"""Objects per file; an interruption loses incomplete files."""
_KINDS = {"packed": "u", "context": "f", "coverage": "f"}
SIZES = (0.98, 1.15)
"""Range of a grid's size in units of the smallest grid around the points."""
SHIFT = 0.04
"""Maximum displacement of a grid's centre, in units of its radius."""


@dataclass(frozen=True, eq=False)
class ScannedInputs:
    """Inputs from r scans of each of n objects.

    Attributes:
        input_spec: The network's inputs.
        packed: (n, r, bytes) uint8, see `encoded`.
        context: (n, r, 6) float32, see `grid_context`.
        coverage: (n, r) float32 coverage of the azimuth; NaN for complete surfaces.
    """

    input_spec: InputSpec
    packed: NDArray[np.uint8]
    context: NDArray[np.float32]
    coverage: NDArray[np.float32]

    @property
    def scans(self) -> int:
        """Number of scans of each object."""
        return self.packed.shape[1]

    def inputs(self, objects: NDArray[np.int64], scans: NDArray[np.int64]) -> NDArray[Any]:
        """(b, *input_shape) inputs of chosen scans; cell states for grids with visibility."""
        return decoded(self.packed[objects, scans], self.input_spec)


def scanned_inputs(
    objects: LabelledSurfaces,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    input_spec: InputSpec,
    folder: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> ScannedInputs:
    """Scan every object several times, using cached scans if available.

    Args:
        objects: The objects.
        augmentation: Settings of the scans.
        scans: Number of scans per object.
        seed: Seed; a scan depends only on the seed, the object's name and the scan's number.
        input_spec: The network's inputs.
        folder: Folder of the cache; None means the user's cache folder.
        progress: Called with (done, all) objects.
        workers: Number of processes; None means one per core.

    Raises:
        MissingExtraError: Embree is not installed.
        OutputError: The cache cannot be written.
    """
    folder = cache_folder("scans") if folder is None else folder
    key = {
        "format": FORMAT, "objects": objects.digest, "augmentation": asdict(augmentation),
        "scans": scans, "seed": seed, "input": [input_spec.kind, *input_spec.input_shape],
        "grid": [*SIZES, SHIFT],
    }  # fmt: skip
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:32]
    starts = range(0, len(objects), CHUNK)
    paths = [folder / f"{name}-{start}.npz" for start in starts]
    sizes = [(min(CHUNK, len(objects) - start), scans) for start in starts]
    wide = width_of(input_spec)
    parts = [_read(path, (*size, wide)) for path, size in zip(paths, sizes, strict=True)]
    missing = [number for number, part in enumerate(parts) if part is None]
    done = sum(size[0] for size, part in zip(sizes, parts, strict=True) if part is not None)
    if missing:
        with worker_pool(workers or os.cpu_count() or 1, _begin_worker, objects) as pool:
            jobs = {
                pool.submit(
                    _scanned_chunk, starts[number], augmentation, scans, seed, input_spec
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
    return ScannedInputs(input_spec, joined[0], joined[1], joined[2])


_SCANNED: list[LabelledSurfaces] = []
"""A worker's objects, sent once instead of with every job."""


def _begin_worker(objects: LabelledSurfaces) -> None:
    _SCANNED[:] = [objects]


def _scanned_chunk(
    start: int,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    input_spec: InputSpec,
) -> dict[str, NDArray[Any]]:
    objects = _SCANNED[0]
    chosen = range(start, min(start + CHUNK, len(objects)))
    packed = np.zeros((len(chosen), scans, width_of(input_spec)), np.uint8)
    context = np.zeros((len(chosen), scans, WIDTH), np.float32)
    coverage = np.full((len(chosen), scans), np.nan, np.float32)
    for row, index in enumerate(chosen):
        caster, name = ObjectCaster(objects.mesh(index)), str(objects.names[index])
        for scan in range(scans):
            rng = chance_of(seed, name, scan)
            found = augmentation.scan(caster, rng, objects.size_factors(index))
            if not len(found.points_xyz):
                continue  # An empty grid: the object was not visible.
            packed[row, scan], context[row, scan], cylinder = encoded(found, input_spec, rng)
            if len(found.ends_xyz):
                coverage[row, scan] = azimuth_coverage(found.views_xyz, cylinder.centre_xyz)
    return {"packed": packed, "context": context, "coverage": coverage}


def chance_of(seed: int, name: str, scan: int) -> np.random.Generator:
    """Random generator that depends only on a seed, an object and the scan's number."""
    digest = hashlib.sha256(f"{seed}/{name}/{scan}".encode(errors="surrogatepass")).digest()
    return np.random.default_rng(np.frombuffer(digest, np.uint32))


def azimuth_coverage(
    views_xyz: NDArray[np.floating], centre_xyz: tuple[float, float, float]
) -> float:
    """Fraction of the directions about an axis that are within 45° of some view."""
    offset = views_xyz[:, :2] - np.asarray(centre_xyz[:2])
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    directions = np.arange(72) * (2 * np.pi / 72)
    apart = np.abs((directions[:, None] - bearings + np.pi) % (2 * np.pi) - np.pi)
    return float((apart <= np.pi / 4).any(axis=1).mean())


def _read(path: Path, shape: tuple[int, int, int]) -> dict[str, NDArray[Any]] | None:
    try:
        found = read_arrays(path, _KINDS)
    except InputError:
        return None
    fits = found["packed"].shape == shape and found["context"].shape == (*shape[:2], WIDTH)
    return found if fits else None


def _write(path: Path, part: dict[str, NDArray[Any]]) -> None:
    with atomic_open(path, "wb") as stream:
        np.savez_compressed(
            stream, packed=part["packed"], context=part["context"], coverage=part["coverage"]
        )


def width_of(input_spec: InputSpec) -> int:
    """Size of a stored scan."""
    if isinstance(input_spec, PointsSpec):
        return input_spec.count * 3 * 2
    assert isinstance(input_spec, GridSpec)
    return -(-_layers(input_spec) * int(np.prod(input_spec.shape)) // 8)


def encoded(
    scan: TrainingScan, input_spec: InputSpec, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float32], CylindricalGrid]:
    """Encode a scan in a grid of slightly random size and position.

    Args:
        scan: A scan with at least one point.
        input_spec: The network's inputs.
        rng: Draws size and position.

    Returns:
        The bytes, the context (6,), and the cylinder.
    """
    cylinder = drawn_cylinder(scan, rng)
    visible = len(scan.ends_xyz) > 0
    if isinstance(input_spec, PointsSpec):
        about = (scan.points_xyz - np.asarray(cylinder.centre_xyz, np.float32)) / cylinder.radius
        shown = input_spec.of_samples(about, rng).astype(np.float16)
        return np.frombuffer(shown.tobytes(), np.uint8), np.zeros(WIDTH, np.float32), cylinder
    assert isinstance(input_spec, GridSpec)
    if input_spec.kind == "rectangular":
        cube = RectangularGrid(input_spec.shape, cylinder.radius, cylinder.centre_xyz)
        occupied = cube.hits(scan.points_xyz).occupied
        return np.packbits(occupied), np.zeros(WIDTH, np.float32), cylinder
    grid = traced(scan, CylindricalGrid(
        input_spec.shape, cylinder.radius, cylinder.half_height, cylinder.centre_xyz
    ))  # fmt: skip
    context = grid_context(grid.occupied, (cylinder.radius, cylinder.half_height), visible=visible)
    return np.packbits(np.stack([grid.occupied, grid.free])), context, cylinder


def decoded(packed: NDArray[np.uint8], input_spec: InputSpec) -> NDArray[Any]:
    """(b, *input_shape) network inputs; cell states for a cylindrical grid."""
    if isinstance(input_spec, PointsSpec):
        rows = np.ascontiguousarray(packed).view(np.float16)
        return rows.reshape(-1, input_spec.count, 3).astype(np.float32)
    assert isinstance(input_spec, GridSpec)
    layers, cells = _layers(input_spec), int(np.prod(input_spec.shape))
    bits = np.unpackbits(packed, axis=1, count=layers * cells)
    found = bits.reshape(-1, layers, *input_spec.shape)
    if layers == 1:
        return found
    occupied, free = found[:, :1], found[:, 1:]
    return (occupied << 1) | (free & ~occupied) if input_spec.visibility else occupied


def drawn_cylinder(scan: TrainingScan, rng: np.random.Generator) -> CylindricalGrid:
    """A cylinder around a scan's points with random size and displacement."""
    points = scan.points_xyz
    centre = points.mean(axis=0)
    about = points - centre
    radius = max(float(np.hypot(about[:, 0], about[:, 1]).max()), float(np.abs(about[:, 2]).max()))
    radius = max(radius, 1e-3) * rng.uniform(*SIZES)
    x, y, z = (centre + rng.uniform(-SHIFT, SHIFT, 3) * radius).tolist()
    return CylindricalGrid(radius=radius, half_height=radius, centre_xyz=(x, y, z))


def traced(scan: TrainingScan, grid: CylindricalGrid) -> OccupancyGrid:
    """The grid of a scan, by ray tracing if the scan has rays."""
    occupied = grid.hits(scan.points_xyz)
    if not len(scan.ends_xyz):
        return occupied
    passed = np.zeros(len(scan.ends_xyz), bool)
    return occupied.merged(grid.trace(scan.origins_xyz, scan.ends_xyz, passed))


def _layers(input_spec: GridSpec) -> int:
    """Number of bits per cell: free cells are stored if rays are traced."""
    return 2 if input_spec.kind == "cylindrical" else 1
