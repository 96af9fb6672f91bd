"""Simulated scans of CAD models and of things of other kinds, as a run trains on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import torch

from circumspect.classification import InputRecipe
from circumspect.datasets import ObjectSet
from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces, digest_of
from circumspect.datasets.scan_sources import of_point_set, procedural
from circumspect.datasets.scanned_inputs import ScannedInputs, scanned_inputs
from circumspect.errors import InputError
from circumspect.training.batches import DrawnBatches
from circumspect.training.held_back import fitted_and_held_back
from circumspect.training.scan_examiner import ScanExaminer
from circumspect.training.scan_samples import ScanSamples
from circumspect.training.settings import TrainingSettings
from circumspect.training.training_data import Progress, TrainingData

HELD_BACK_SCANS = 4
"""Of each object that is held back."""
HELD_BACK_SEED = 7
"""Their chance; another one than that of the scans that train."""

Source = tuple[LabelledSurfaces, int, float]
"""Objects, the scans of each, and their share of the draws."""
Scanned = Callable[[LabelledSurfaces, int, int, Progress], ScannedInputs]
"""Scans of objects: how many of each, by what chance."""


def scan_data(
    objects: ObjectSet,
    catalogues: Sequence[LabelledSurfaces],
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
    classes = (*objects.classes, OTHER)
    _require_known_classes(catalogues, classes)
    training, held_back = _divided(objects, catalogues, settings)

    def scanned(of: LabelledSurfaces, scans: int, seed: int, report: Progress) -> ScannedInputs:
        return scanned_inputs(of, settings.scan, scans, seed, recipe, cache, report)

    sources = _scans_to_train_on(training, settings.seed, scanned, progress)
    examiner = None
    if held_back:
        scans = [scanned(of, HELD_BACK_SCANS, HELD_BACK_SEED, progress) for of in held_back]
        examiner = ScanExaminer(list(zip(scans, held_back, strict=True)), classes, device)
    fitted = [name for of, _, _ in training for name in of.names.tolist()]
    return TrainingData(
        classes,
        digest_of([objects.digest, *(catalogue.digest for catalogue in catalogues)]),
        len(fitted),
        fitted,
        sum(map(len, held_back)),
        DrawnBatches(ScanSamples(sources, classes, settings), settings),
        examiner,
    )


def _require_known_classes(catalogues: Sequence[LabelledSurfaces], classes: Sequence[str]) -> None:
    for catalogue in catalogues:
        if strange := sorted(set(catalogue.labels.tolist()) - set(classes)):
            raise InputError(f"the catalogue has classes that the set lacks: {', '.join(strange)}")


def _divided(
    objects: ObjectSet, catalogues: Sequence[LabelledSurfaces], settings: TrainingSettings
) -> tuple[list[Source], list[LabelledSurfaces]]:
    """What trains, and what is held back, where anything is to be."""
    fit, validation = fitted_and_held_back(objects, settings)
    own = 1.0 - settings.catalogue - settings.furniture
    training = [(of_point_set(fit), settings.replicas, own)]
    held_back = [of_point_set(validation)] if settings.validation else []
    for catalogue in catalogues:
        mask = catalogue.held_back() & settings.validation
        share = settings.catalogue / len(catalogues)
        training.append((catalogue.subset(~mask), settings.catalogue_replicas, share))
        held_back += [catalogue.subset(mask)] if mask.any() else []
    if settings.furniture:
        made = procedural(settings.furniture_each, settings.furniture_others)
        training.append((made, settings.replicas, settings.furniture))
    return training, held_back


def _scans_to_train_on(
    training: Sequence[Source], seed: int, scanned: Scanned, progress: Progress
) -> list[tuple[ScannedInputs, LabelledSurfaces, float]]:
    sources = []
    for at, (of, scans, share) in enumerate(training):

        def report(done: int, count: int, at: int = at) -> None:
            # One bar for all sources.
            progress(at * count + done, len(training) * count)

        sources.append((scanned(of, scans, seed, report), of, share))
    return sources
