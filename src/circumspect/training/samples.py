"""The training objects of a run, including procedural furniture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.augmented_clouds import AugmentedClouds, AugmentedGrids, AugmentedPoints
from circumspect.datasets.furniture_set import furniture_set
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES
from circumspect.training.draws import class_chances
from circumspect.training.settings import TrainingSettings


class TrainingSamples:
    """Augmented inputs of all sources under one index.

    Args:
        fit: The training objects.
        settings: Settings of the run.
        input_spec: The network's inputs.
        cache: Cache of the inputs.
        progress: Called with (done, all) while inputs are made.

    Raises:
        InputError: Furniture is requested, but the set has classes without any.
        OutputError: The cache cannot be written.
    """

    def __init__(
        self,
        fit: ObjectSet,
        settings: TrainingSettings,
        input_spec: InputSpec,
        cache: GridCache,
        progress: Callable[[int, int], None],
    ) -> None:
        sources = [(fit, 1.0 - settings.furniture)]
        if settings.furniture:
            sources.append((_furniture_of(fit.classes, settings), settings.furniture))
        self.epoch = settings.passes * len(fit)
        """Number of objects drawn per epoch."""
        self.chances = np.concatenate(
            [share * class_chances(source.labels, settings.balance) for source, share in sources]
        )
        """(n,) probability of each object; they sum to 1."""
        labels = np.concatenate([source.labels for source, _ in sources])
        self.targets = np.eye(len(fit.classes), dtype=np.float32)[labels]
        """(n, c) one-hot targets."""
        self._starts = np.cumsum([0] + [len(source) for source, _ in sources])
        self._parts = [
            _augmented(source, settings, input_spec, cache, progress) for source, _ in sources
        ]

    def inputs(
        self,
        chosen: NDArray[np.int64],
        replicas: NDArray[np.int64],
        rng: np.random.Generator | None = None,  # noqa: ARG002 - variants are drawn beforehand
    ) -> tuple[NDArray[Any]]:
        """Inputs of chosen objects, see `Samples.inputs`: only (b, *input_shape)."""
        part = np.searchsorted(self._starts, chosen, side="right") - 1
        local = chosen - self._starts[part]
        made = {p: self._parts[p].batch(local[part == p], replicas[part == p]) for p in set(part)}
        inputs = np.empty((len(chosen), *made[part[0]].shape[1:]), made[part[0]].dtype)
        for p, found in made.items():
            inputs[part == p] = found
        return (inputs,)


def _augmented(
    source: ObjectSet,
    settings: TrainingSettings,
    input_spec: InputSpec,
    cache: GridCache,
    progress: Callable[[int, int], None],
) -> AugmentedGrids | AugmentedPoints:
    filled = not isinstance(input_spec, PointsSpec) or input_spec.surface
    changes = settings.changes(input_spec.margin)
    clouds = AugmentedClouds(source, changes, settings.seed, filled, settings.random_yaw)
    if isinstance(input_spec, PointsSpec):
        return AugmentedPoints(clouds, input_spec)
    assert isinstance(input_spec, GridSpec)
    return AugmentedGrids(clouds, input_spec, settings.replicas, cache, progress)


def _furniture_of(classes: tuple[str, ...], settings: TrainingSettings) -> ObjectSet:
    """Procedural furniture of these classes, with labels in their order."""
    if missing := set(classes) - set(CATEGORIES):
        raise InputError(
            f"no procedural furniture of class {', '.join(sorted(missing))}; train without it"
        )
    made = furniture_set(settings.furniture_each)
    wanted = made.subset(np.isin(made.labels, [made.classes.index(name) for name in classes]))
    labels = np.array([classes.index(made.classes[label]) for label in wanted.labels])
    return ObjectSet(wanted.points_xyz, labels, wanted.names, classes)
