"""Training data from simulated scans of CAD models and of objects of other kinds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from circumspect.classification import InputSpec
from circumspect.classification.context import SCALE_KNOWN, VISIBILITY_KNOWN
from circumspect.datasets import ObjectSet
from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces, digest_of
from circumspect.datasets.scan_sources import of_point_set, procedural
from circumspect.datasets.scanned_inputs import ScannedInputs, scanned_inputs
from circumspect.errors import InputError
from circumspect.evaluation.accuracy import mean_class_accuracy
from circumspect.grid.grid import OCCUPIED
from circumspect.nets.state_channels import state_channels
from circumspect.training.batches import DrawnBatches
from circumspect.training.draws import class_chances
from circumspect.training.settings import TrainingSettings
from circumspect.training.training_data import Progress, TrainingData, fitted_and_held_back

HELD_BACK_SCANS = 4
"""Number of scans per held-back object."""
HELD_BACK_SEED = 7
"""Seed of these scans; differs from the seed of training scans."""
Source = tuple[LabelledSurfaces, int, float]
"""Objects, number of scans per object, and fraction of the draws."""
Scanned = Callable[[LabelledSurfaces, int, int, Progress], ScannedInputs]
"""Makes scans of objects, given their number per object and a seed."""
BATCH = 64


class ScanExaminer:
    """Measures a network on scans.

    Args:
        sources: Scans and their objects.
        classes: Classes of the network's outputs, "other" last.
        device: Device of the network.
    """

    def __init__(
        self,
        sources: Sequence[tuple[ScannedInputs, LabelledSurfaces]],
        classes: Sequence[str],
        device: torch.device,
    ) -> None:
        self._device, self._known = device, len(classes) - (OTHER in classes)
        rows, contexts, labels = [], [], []
        for grids, objects in sources:
            count, scans = grids.packed.shape[:2]
            of, scan = np.repeat(np.arange(count), scans), np.tile(np.arange(scans), count)
            rows.append((of, scan))
            contexts.append(grids.context[of, scan])
            labels.append(np.array([classes.index(label) for label in objects.labels.tolist()])[of])
        self._sources, self._rows = [grids for grids, _ in sources], rows
        self._contexts, self._labels = contexts, np.concatenate(labels)

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class and instance accuracy without "other", and the loss over all objects."""
        net.eval()
        logits = torch.cat(
            [
                self._logits(net, grids, rows, context)
                for grids, rows, context in zip(
                    self._sources, self._rows, self._contexts, strict=True
                )
            ]
        )
        labels = torch.from_numpy(self._labels)
        known = self._labels < self._known
        right = (logits[:, : self._known].argmax(1) == labels).numpy()[known].astype(float)
        return {
            "validation_accuracy": mean_class_accuracy(right, self._labels[known], self._known),
            "validation_instance_accuracy": float(right.mean()),
            "validation_loss": float(functional.cross_entropy(logits, labels)),
        }

    @torch.no_grad()
    def _logits(
        self,
        net: nn.Module,
        grids: ScannedInputs,
        rows: tuple[NDArray[np.int64], NDArray[np.int64]],
        contexts: NDArray[np.float32],
    ) -> Tensor:
        found = []
        for start in range(0, len(contexts), BATCH):
            part = slice(start, start + BATCH)
            inputs = torch.from_numpy(grids.inputs(rows[0][part], rows[1][part]))
            shown = [inputs.float()]
            if grids.input_spec.takes_context:
                shown = [state_channels(inputs), torch.from_numpy(contexts[part])]
            found.append(net(*(one.to(self._device) for one in shown)).float().cpu())
        return torch.cat(found)


class ScanSamples:
    """Scans of several sources under one index, see `Samples`.

    Args:
        sources: Scans, their objects, and their fraction of the draws.
        classes: Classes of the network's outputs.
        settings: Settings of the run.
    """

    def __init__(
        self,
        sources: Sequence[tuple[ScannedInputs, LabelledSurfaces, float]],
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
        """Inputs, and contexts if the network takes them; some hide free cells or the scale."""
        part = np.searchsorted(self._starts, chosen, side="right") - 1
        input_spec = self._sources[0].input_spec
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
        if not input_spec.takes_context:
            return (made,)
        hidden = rng.random(len(chosen)) < self._settings.hide_visibility
        made[hidden] &= np.uint8(OCCUPIED)
        contexts[hidden, VISIBILITY_KNOWN] = 0.0
        contexts[rng.random(len(chosen)) < self._settings.hide_scale, SCALE_KNOWN:] = 0.0
        return made, contexts


def _class_chances(
    labels: NDArray[np.int64], other: int, settings: TrainingSettings
) -> NDArray[np.float64]:
    """Probabilities of a source's objects; objects of no class have their own weight."""
    known = labels != other
    chances = np.zeros(len(labels))
    chances[known] = class_chances(labels[known], settings.balance)
    if not known.all():
        classes = len(np.unique(labels[known]))
        weight = settings.other_weight / max(classes, 1)
        chances[~known] = weight / np.count_nonzero(~known)
    return chances / chances.sum()


def scan_data(
    objects: ObjectSet,
    catalogues: Sequence[LabelledSurfaces],
    settings: TrainingSettings,
    input_spec: InputSpec,
    device: torch.device,
    progress: Progress,
    cache: Path | None = None,
) -> TrainingData:
    """Simulated scans of a labelled set, of furniture catalogues, and of procedural objects.

    Args:
        objects: The labelled set; it defines the classes.
        catalogues: Objects of known size, of the classes or of other kinds.
        settings: Settings of the run.
        input_spec: The network's inputs.
        device: Device of the network.
        progress: Called with (done, all) objects while they are scanned.
        cache: Folder of cached scans; None means the user's cache folder.

    Raises:
        InputError: A class has no known size or no training object.
        OutputError: The cache cannot be written.
        MissingExtraError: Embree is not installed.
    """
    classes = (*objects.classes, OTHER)
    _require_known_classes(catalogues, classes)
    training, held_back = _split_sources(objects, catalogues, settings)

    def scanned(of: LabelledSurfaces, scans: int, seed: int, report: Progress) -> ScannedInputs:
        return scanned_inputs(of, settings.scan, scans, seed, input_spec, cache, report)

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


def _split_sources(
    objects: ObjectSet, catalogues: Sequence[LabelledSurfaces], settings: TrainingSettings
) -> tuple[list[Source], list[LabelledSurfaces]]:
    """The training objects and the held-back ones, if any."""
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
            # One progress bar for all sources.
            progress(at * count + done, len(training) * count)

        sources.append((scanned(of, scans, seed, report), of, share))
    return sources
