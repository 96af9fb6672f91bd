"""Simulated scans of training objects as network inputs, made once and cached."""

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

from circumspect.classification import InputRecipe
from circumspect.classification.context import WIDTH
from circumspect.datasets.cache_folder import cache_folder
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import ScanAugmentation
from circumspect.datasets.scan_encoding import SHIFT, SIZES, decoded, encoded, width_of
from circumspect.datasets.worker_pool import worker_pool
from circumspect.errors import InputError
from circumspect.geometry.npy_stream import read_arrays
from circumspect.storage import atomic_open

FORMAT = 2
CHUNK = 32
"""Objects a file: what an interruption loses."""
_KINDS = {"packed": "u", "context": "f", "coverage": "f"}


@dataclass(frozen=True, eq=False)
class ScannedInputs:
    """Inputs from n objects, r scans each.

    Attributes:
        recipe: What the network is shown.
        packed: (n, r, bytes) uint8, see `scan_encoding`.
        context: (n, r, 6) float32, see `grid_context`.
        coverage: (n, r) float32 share of the azimuth seen, NaN for complete surfaces.
    """

    recipe: InputRecipe
    packed: NDArray[np.uint8]
    context: NDArray[np.float32]
    coverage: NDArray[np.float32]

    @property
    def scans(self) -> int:
        """Of each object."""
        return self.packed.shape[1]

    def inputs(self, objects: NDArray[np.int64], scans: NDArray[np.int64]) -> NDArray[Any]:
        """(b, *input_shape) of chosen scans; of a cylindrical grid with visibility its states."""
        return decoded(self.packed[objects, scans], self.recipe)


def scanned_inputs(
    objects: LabelledSurfaces,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    recipe: InputRecipe,
    folder: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> ScannedInputs:
    """Scan every object several times; a part that is cached is not made again.

    Args:
        objects: What is scanned.
        augmentation: How.
        scans: Of each object.
        seed: Of all chance; a scan depends on it, the object's name and its number alone.
        recipe: What the network is shown.
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
        "scans": scans, "seed": seed, "input": [recipe.kind, *recipe.input_shape],
        "grid": [*SIZES, SHIFT],
    }  # fmt: skip
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:32]
    starts = range(0, len(objects), CHUNK)
    paths = [folder / f"{name}-{start}.npz" for start in starts]
    sizes = [(min(CHUNK, len(objects) - start), scans) for start in starts]
    wide = width_of(recipe)
    parts = [_read(path, (*size, wide)) for path, size in zip(paths, sizes, strict=True)]
    missing = [number for number, part in enumerate(parts) if part is None]
    done = sum(size[0] for size, part in zip(sizes, parts, strict=True) if part is not None)
    if missing:
        with worker_pool(workers or os.cpu_count() or 1, _begin_worker, objects) as pool:
            jobs = {
                pool.submit(
                    _scanned_chunk, starts[number], augmentation, scans, seed, recipe
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
    return ScannedInputs(recipe, joined[0], joined[1], joined[2])


_SCANNED: list[LabelledSurfaces] = []
"""What a worker scans: given once, not with every job."""


def _begin_worker(objects: LabelledSurfaces) -> None:
    _SCANNED[:] = [objects]


def _scanned_chunk(
    start: int,
    augmentation: ScanAugmentation,
    scans: int,
    seed: int,
    recipe: InputRecipe,
) -> dict[str, NDArray[Any]]:
    objects = _SCANNED[0]
    chosen = range(start, min(start + CHUNK, len(objects)))
    packed = np.zeros((len(chosen), scans, width_of(recipe)), np.uint8)
    context = np.zeros((len(chosen), scans, WIDTH), np.float32)
    coverage = np.full((len(chosen), scans), np.nan, np.float32)
    for row, index in enumerate(chosen):
        caster, name = ObjectCaster(objects.mesh(index)), str(objects.names[index])
        for scan in range(scans):
            rng = chance_of(seed, name, scan)
            found = augmentation.scan(caster, rng, objects.size_factors(index))
            if not len(found.points_xyz):
                continue  # Nothing of it was seen: an empty grid.
            packed[row, scan], context[row, scan], cylinder = encoded(found, recipe, rng)
            if len(found.ends_xyz):
                coverage[row, scan] = azimuth_coverage(found.views_xyz, cylinder.centre_xyz)
    return {"packed": packed, "context": context, "coverage": coverage}


def chance_of(seed: int, name: str, scan: int) -> np.random.Generator:
    """Chance that depends on a seed, an object and the number of its scan alone."""
    digest = hashlib.sha256(f"{seed}/{name}/{scan}".encode(errors="surrogatepass")).digest()
    return np.random.default_rng(np.frombuffer(digest, np.uint32))


def azimuth_coverage(
    views_xyz: NDArray[np.floating], centre_xyz: tuple[float, float, float]
) -> float:
    """Share of the directions about an axis that are within 45° of some view."""
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
