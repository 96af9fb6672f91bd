"""What a run draws its batches from: the training objects, and procedural furniture beside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import GridRecipe, InputRecipe, PointsRecipe
from circumspect.datasets import GridCache, ObjectSet
from circumspect.datasets.augmented_clouds import AugmentedClouds
from circumspect.datasets.augmented_grids import AugmentedGrids
from circumspect.datasets.augmented_points import AugmentedPoints
from circumspect.datasets.furniture_set import furniture_set
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES
from circumspect.training.draws import class_chances
from circumspect.training.settings import TrainingSettings


class TrainingSamples:
    """Augmented inputs of all sources under one index.

    Args:
        fit: The training objects.
        settings: Of the run.
        recipe: What the network is shown.
        cache: Where they are kept.
        progress: Called with (done, all) while they are made.

    Raises:
        InputError: Furniture is asked for, but the set has classes that it does not cover.
        OutputError: The cache can not be written.
    """

    def __init__(
        self,
        fit: ObjectSet,
        settings: TrainingSettings,
        recipe: InputRecipe,
        cache: GridCache,
        progress: Callable[[int, int], None],
    ) -> None:
        sources = [(fit, 1.0 - settings.furniture)]
        if settings.furniture:
            sources.append((_furniture_of(fit.classes, settings), settings.furniture))
        self.epoch = settings.passes * len(fit)
        """Draws an epoch."""
        self.chances = np.concatenate(
            [share * class_chances(source.labels, settings.balance) for source, share in sources]
        )
        """(n,) chance of each object; they sum to 1."""
        labels = np.concatenate([source.labels for source, _ in sources])
        self.targets = np.eye(len(fit.classes), dtype=np.float32)[labels]
        """(n, c) one-hot targets."""
        self._starts = np.cumsum([0] + [len(source) for source, _ in sources])
        self._parts = [
            _augmented(source, settings, recipe, cache, progress) for source, _ in sources
        ]

    def inputs(
        self,
        chosen: NDArray[np.int64],
        replicas: NDArray[np.int64],
        rng: np.random.Generator | None = None,  # noqa: ARG002 - variants are drawn beforehand
    ) -> tuple[NDArray[Any]]:
        """Inputs of chosen objects, see `Samples.inputs`; (b, *input_shape) alone."""
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
    recipe: InputRecipe,
    cache: GridCache,
    progress: Callable[[int, int], None],
) -> AugmentedGrids | AugmentedPoints:
    filled = not isinstance(recipe, PointsRecipe) or recipe.surface
    changes = settings.changes(recipe.margin)
    clouds = AugmentedClouds(source, changes, settings.seed, filled, settings.random_yaw)
    if isinstance(recipe, PointsRecipe):
        return AugmentedPoints(clouds, recipe)
    assert isinstance(recipe, GridRecipe)
    return AugmentedGrids(clouds, recipe, settings.replicas, cache, progress)


def _furniture_of(classes: tuple[str, ...], settings: TrainingSettings) -> ObjectSet:
    """Procedural furniture of these classes, labelled in their order."""
    if missing := set(classes) - set(CATEGORIES):
        raise InputError(
            f"no procedural furniture of class {', '.join(sorted(missing))}; train without it"
        )
    made = furniture_set(settings.furniture_each)
    wanted = made.subset(np.isin(made.labels, [made.classes.index(name) for name in classes]))
    labels = np.array([classes.index(made.classes[label]) for label in wanted.labels])
    return ObjectSet(wanted.points_xyz, labels, wanted.names, classes)
