"""Simulated scans of several sources under one index."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import SCALE_KNOWN, VISIBILITY_KNOWN
from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces
from circumspect.datasets.scanned_inputs import ScannedInputs
from circumspect.grid.occupancy_grid import OCCUPIED
from circumspect.training.draws import class_chances
from circumspect.training.settings import TrainingSettings


class ScanSamples:
    """Scans of several sources under one index, see `Samples`.

    Args:
        sources: Scans, the objects that they are of, and the share of the draws.
        classes: Of the network's outputs.
        settings: Of the run.
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
