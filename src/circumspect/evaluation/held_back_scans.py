"""Simulated scans of objects that were held back, shown to a classifier as a robot shows them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe
from circumspect.classification.context import VISIBILITY_KNOWN
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import FEWEST, ScanAugmentation, SimulatedScan
from circumspect.datasets.scanned_inputs import azimuth_coverage, chance_of
from circumspect.datasets.worker_pool import worker_pool
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid
from circumspect.grid.occupancy_grid import OCCUPIED

CHUNK = 8
"""Objects a job."""
_Row = tuple[NDArray[Any], Any, float, str]
"""Views, context, coverage and label of a scan."""


@dataclass(frozen=True, eq=False)
class HeldBackScans:
    """Inputs of n scans, all views of each.

    Attributes:
        inputs: (n, views, 1, *shape) uint8.
        contexts: (n, 6) float32.
        labels: (n,) text.
        coverage: (n,) share of the azimuth seen, NaN for complete surfaces.
    """

    inputs: NDArray[np.uint8]
    contexts: NDArray[np.float32]
    labels: NDArray[np.str_]
    coverage: NDArray[np.float64]

    def with_rays(self) -> HeldBackScans:
        """The scans alone, without complete surfaces."""
        chosen = np.isfinite(self.coverage)
        return HeldBackScans(
            self.inputs[chosen], self.contexts[chosen], self.labels[chosen], self.coverage[chosen]
        )

    def without_rays(self) -> HeldBackScans:
        """The same as clouds in files, of which nobody knows what was free or from where."""
        contexts = self.contexts.copy()
        contexts[:, VISIBILITY_KNOWN] = 0.0
        return HeldBackScans(self.inputs & np.uint8(OCCUPIED), contexts, self.labels, self.coverage)


def held_back_scans(
    sources: Sequence[LabelledSurfaces],
    augmentation: ScanAugmentation,
    recipe: GridRecipe,
    scans: int,
    seed: int = 7,
    progress: Callable[[int, int], None] | None = None,
    keep_all: bool = False,
) -> HeldBackScans:
    """Scan objects several times each.

    Args:
        sources: What was held back.
        augmentation: How they are scanned.
        recipe: How the classifier is shown them, with all its views.
        scans: Of each object.
        seed: Of all chance.
        progress: Called with (done, all) objects.
        keep_all: Also scans that hardly show the object; otherwise they are left out.

    Raises:
        MissingExtraError: Embree is not installed.
    """
    how = _Scanning(augmentation, recipe, scans, seed, 3 if keep_all else FEWEST)
    rows: list[_Row] = []
    done, total = 0, sum(map(len, sources))
    with worker_pool(os.cpu_count() or 1, _begin_worker, list(sources), how) as pool:
        jobs = [
            pool.submit(_scanned, number, range(start, min(start + CHUNK, len(objects))))
            for number, objects in enumerate(sources)
            for start in range(0, len(objects), CHUNK)
        ]
        for job in jobs:
            objects, found = job.result()
            rows += found
            done += objects
            if progress:
                progress(done, total)
    inputs, contexts, coverages, labels = zip(*rows, strict=True)
    return HeldBackScans(
        np.stack(inputs), np.array(contexts, np.float32), np.array(labels, np.str_),
        np.array(coverages),
    )  # fmt: skip


@dataclass(frozen=True)
class _Scanning:
    """What all scans share; those of fewer points than `fewest` are left out."""

    augmentation: ScanAugmentation
    recipe: GridRecipe
    scans: int
    seed: int
    fewest: int


_SHARED: list[tuple[list[LabelledSurfaces], _Scanning]] = []
"""What a worker scans: given once, not with every job."""


def _begin_worker(sources: list[LabelledSurfaces], how: _Scanning) -> None:
    _SHARED[:] = [(sources, how)]


def _scanned(source: int, chosen: range) -> tuple[int, list[_Row]]:
    """How many objects were scanned, and their scans."""
    sources, how = _SHARED[0]
    objects, rows = sources[source], []
    for index in chosen:
        caster, name = ObjectCaster(objects.mesh(index)), str(objects.names[index])
        for number in range(how.scans):
            chance = chance_of(how.seed, name, number)
            scan = how.augmentation.scan(caster, chance, objects.size_factors(index))
            if len(scan.points_xyz) >= how.fewest:
                rows.append((*_shown(scan, how.recipe), str(objects.labels[index])))
    return len(chosen), rows


def _shown(scan: SimulatedScan, recipe: GridRecipe) -> tuple[NDArray[Any], Any, float]:
    """All views of a scan, its context and its coverage."""
    cloud = PointCloud(scan.points_xyz.astype(np.float64))
    bounds = recipe.bounds(cloud)
    grids = recipe.all_bounds(bounds)
    found = [grid.hits(cloud) for grid in grids]
    coverage = np.nan
    if len(scan.ends_xyz):
        passed = np.zeros(len(scan.ends_xyz), bool)
        traced = [grid.trace(scan.origins_xyz, scan.ends_xyz, passed) for grid in grids]
        found = [a.merged(b) for a, b in zip(found, traced, strict=True)]
        assert isinstance(bounds, CylindricalGrid)
        coverage = azimuth_coverage(scan.views_xyz, bounds.centre_xyz)
    inputs = np.stack([recipe.input_of(grid) for grid in found])
    return inputs, recipe.context(inputs, bounds), coverage
