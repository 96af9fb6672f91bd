"""Simulated scans of CAD models and of things of other kinds, as a run trains on them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from circumspect.classification import InputRecipe
from circumspect.classification.context import SCALE_KNOWN, VISIBILITY_KNOWN
from circumspect.datasets import ObjectSet
from circumspect.datasets.scan_sources import of_point_set, procedural
from circumspect.datasets.scanned_inputs import ScannedInputs, scanned_inputs
from circumspect.datasets.training_objects import OTHER, TrainingObjects, digest_of
from circumspect.errors import InputError
from circumspect.grid.occupancy_grid import OCCUPIED
from circumspect.training.draws import class_chances
from circumspect.training.held_back import fitted_and_held_back
from circumspect.training.scan_examiner import ScanExaminer
from circumspect.training.settings import TrainingSettings
from circumspect.training.training_data import Progress, TrainingData

HELD_BACK_SCANS = 4
"""Of each object that is held back."""
HELD_BACK_SEED = 7
"""Their chance; another one than that of the scans that train."""


class ScanSamples:
    """Scans of several sources under one index, see `Samples`.

    Args:
        sources: Scans, the objects that they are of, and the share of the draws.
        classes: Of the network's outputs.
        settings: Of the run.
    """

    def __init__(
        self,
        sources: Sequence[tuple[ScannedInputs, TrainingObjects, float]],
        classes: Sequence[str],
        settings: TrainingSettings,
    ) -> None:
        self._sources = [grids for grids, _, _ in sources]
        self._settings = settings
        self._starts = np.cumsum([0, *(len(objects) for _, objects, _ in sources)])
        labels = [
            np.array([classes.index(label) for label in objects.labels.tolist()])
            for _, objects, _ in sources
        ]
        chances = [
            share * _class_chances(of, classes.index(OTHER), settings)
            for of, (_, _, share) in zip(labels, sources, strict=True)
        ]
        self.chances = np.concatenate(chances)
        self.chances /= self.chances.sum()
        self.targets = np.eye(len(classes), dtype=np.float32)[np.concatenate(labels)]
        self.epoch = settings.draws or len(self.chances)

    def inputs(
        self, chosen: NDArray[np.int64], replicas: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[NDArray[Any], ...]:
        """Inputs, and contexts where the network takes them; some hide free cells or the scale."""
        part = np.searchsorted(self._starts, chosen, side="right") - 1
        recipe = self._sources[0].recipe
        made: NDArray[Any] | None = None
        contexts = np.empty((len(chosen), self._sources[0].context.shape[-1]), np.float32)
        for number in np.unique(part):
            of, source = part == number, self._sources[number]
            local = chosen[of] - self._starts[number]
            scan = replicas[of] % source.scans
            found = source.inputs(local, scan)
            if made is None:
                made = np.empty((len(chosen), *found.shape[1:]), found.dtype)
            made[of] = found
            contexts[of] = source.context[local, scan]
        assert made is not None
        if not recipe.takes_context:
            return (made,)
        hidden = rng.random(len(chosen)) < self._settings.hide_visibility
        made[hidden] &= np.uint8(OCCUPIED)
        contexts[hidden, VISIBILITY_KNOWN] = 0.0
        contexts[rng.random(len(chosen)) < self._settings.hide_scale, SCALE_KNOWN:] = 0.0
        return made, contexts


def scan_data(
    objects: ObjectSet,
    catalogues: Sequence[TrainingObjects],
    settings: TrainingSettings,
    recipe: InputRecipe,
    device: torch.device,
    progress: Progress,
    cache: Path | None = None,
) -> TrainingData:
    """Simulated scans of a labelled set, of catalogues of furniture, and of procedural things.

    Args:
        objects: The labelled set; it names the classes.
        catalogues: Objects of true size, of the classes or of other kinds.
        settings: Of the run.
        recipe: What the network is shown.
        device: Where the network runs.
        progress: Called with (done, all) objects while they are scanned.
        cache: Where scans are kept; None means the user's cache folder.

    Raises:
        InputError: A class without a known size, or one that no object that trains has.
        OutputError: The cache can not be written.
        MissingExtraError: Embree is not installed.
    """
    fit, validation = fitted_and_held_back(objects, settings)
    classes = (*objects.classes, OTHER)
    for catalogue in catalogues:
        if strange := sorted(set(catalogue.labels.tolist()) - set(classes)):
            raise InputError(f"the catalogue has classes that the set lacks: {', '.join(strange)}")
    held = [c.held_back() & settings.validation for c in catalogues]
    training = [
        (of_point_set(fit), settings.replicas, 1.0 - settings.catalogue - settings.furniture)
    ]
    for catalogue, mask in zip(catalogues, held, strict=True):
        share = settings.catalogue / len(catalogues)
        training.append((catalogue.subset(~mask), settings.catalogue_replicas, share))
    if settings.furniture:
        made = procedural(settings.furniture_each, settings.furniture_others)
        training.append((made, settings.replicas, settings.furniture))

    def scanned(
        of: TrainingObjects, scans: int, seed: int, at: int = 0, total: int = 1
    ) -> ScannedInputs:
        # One bar for all sources.
        def shown(done: int, count: int) -> None:
            progress(at * count + done, total * count)

        return scanned_inputs(of, settings.scan, scans, seed, recipe, cache, shown)

    sources = [
        (scanned(of, scans, settings.seed, at, len(training)), of, share)
        for at, (of, scans, share) in enumerate(training)
    ]
    examiner, count = None, 0
    if settings.validation:
        parts = [of_point_set(validation)]
        parts += [c.subset(mask) for c, mask in zip(catalogues, held, strict=True) if mask.any()]
        examiner = ScanExaminer(
            [(scanned(of, HELD_BACK_SCANS, HELD_BACK_SEED), of) for of in parts], classes, device
        )
        count = sum(map(len, parts))
    fitted = [name for of, _, _ in training for name in of.names.tolist()]
    digest = digest_of([objects.digest, *(catalogue.digest for catalogue in catalogues)])
    samples = ScanSamples(sources, classes, settings)
    return TrainingData(classes, digest, fitted, count, samples, examiner)


def _class_chances(
    labels: NDArray[np.int64], other: int, settings: TrainingSettings
) -> NDArray[np.float64]:
    """Chances of a source's objects; other things have a share of their own."""
    known = labels != other
    chances = np.zeros(len(labels))
    chances[known] = class_chances(labels[known], settings.balance)
    if not known.all():
        classes = len(np.unique(labels[known]))
        weight = settings.other_weight / max(classes, 1)
        chances[~known] = weight / np.count_nonzero(~known)
    return chances / chances.sum()
