"""Simulated scans of held-back objects as a classifier's inputs on a robot."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridSpec
from circumspect.classification.context import VISIBILITY_KNOWN
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import MIN_VOXELS, ScanAugmentation, TrainingScan
from circumspect.datasets.scanned_inputs import azimuth_coverage, chance_of
from circumspect.datasets.worker_pool import worker_pool
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid
from circumspect.grid.grid import OCCUPIED

CHUNK = 8
"""Objects per job."""
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
        """The same objects as clouds from files, without free space and coverage."""
        contexts = self.contexts.copy()
        contexts[:, VISIBILITY_KNOWN] = 0.0
        return HeldBackScans(self.inputs & np.uint8(OCCUPIED), contexts, self.labels, self.coverage)


def held_back_scans(
    sources: Sequence[LabelledSurfaces],
    augmentation: ScanAugmentation,
    input_spec: GridSpec,
    scans: int,
    seed: int = 7,
    progress: Callable[[int, int], None] | None = None,
    keep_all: bool = False,
) -> HeldBackScans:
    """Scan objects several times each.

    Args:
        sources: Held-back objects.
        augmentation: Settings of the scans.
        input_spec: The classifier's inputs, with all its views.
        scans: Scans of each object.
        seed: Of all random generators.
        progress: Called with (done, all) objects.
        keep_all: Also keep scans that hardly show the object.

    Raises:
        MissingExtraError: Embree is not installed.
    """
    how = _Scanning(augmentation, input_spec, scans, seed, 3 if keep_all else MIN_VOXELS)
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
    """Settings that all scans share; scans of fewer points than `min_points` are left out."""

    augmentation: ScanAugmentation
    input_spec: GridSpec
    scans: int
    seed: int
    min_points: int


_SHARED: list[tuple[list[LabelledSurfaces], _Scanning]] = []
"""A worker's objects, sent once instead of with every job."""


def _begin_worker(sources: list[LabelledSurfaces], how: _Scanning) -> None:
    _SHARED[:] = [(sources, how)]


def _scanned(source: int, chosen: range) -> tuple[int, list[_Row]]:
    """Number of scanned objects, and their scans."""
    sources, how = _SHARED[0]
    objects, rows = sources[source], []
    for index in chosen:
        caster, name = ObjectCaster(objects.mesh(index)), str(objects.names[index])
        for number in range(how.scans):
            chance = chance_of(how.seed, name, number)
            scan = how.augmentation.scan(caster, chance, objects.size_factors(index))
            if len(scan.points_xyz) >= how.min_points:
                rows.append((*_shown(scan, how.input_spec), str(objects.labels[index])))
    return len(chosen), rows


def _shown(scan: TrainingScan, input_spec: GridSpec) -> tuple[NDArray[Any], Any, float]:
    """All views of a scan, its context and its coverage."""
    cloud = PointCloud(scan.points_xyz.astype(np.float64))
    bounds = input_spec.bounds(cloud)
    grids = input_spec.all_bounds(bounds)
    found = [grid.hits(cloud) for grid in grids]
    coverage = np.nan
    if len(scan.ends_xyz):
        passed = np.zeros(len(scan.ends_xyz), bool)
        traced = [grid.trace(scan.origins_xyz, scan.ends_xyz, passed) for grid in grids]
        found = [a.merged(b) for a, b in zip(found, traced, strict=True)]
        assert isinstance(bounds, CylindricalGrid)
        coverage = azimuth_coverage(scan.views_xyz, bounds.centre_xyz)
    inputs = np.stack([input_spec.input_of(grid) for grid in found])
    return inputs, input_spec.context(inputs, bounds), coverage
