"""A set in shards, as a run trains on it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Self

import numpy as np
import torch

from circumspect.classification import GridRecipe, recipe_from_dict
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.errors import InputError
from circumspect.training.batches import Batch
from circumspect.training.settings import TrainingSettings
from circumspect.training.shard_examiner import ShardExaminer
from circumspect.training.training_data import TrainingData


class ShardedTraining:
    """The splits of a sharded set that a run needs.

    Attributes:
        train: What trains.
        validation: What was held back when the shards were made.
    """

    def __init__(self, train: ShardedSet, validation: ShardedSet) -> None:
        """Use splits that are open; see `read`."""
        self.train, self.validation = train, validation

    @classmethod
    def read(cls, url: str | os.PathLike[str]) -> Self:
        """Open the training and the validation split.

        Args:
            url: Of the set, a folder or a URL.

        Raises:
            InputError: A shard is missing or broken, or the splits do not fit each other.
            MissingExtraError: pyarrow or fsspec is not installed.
        """
        with ExitStack() as opened:
            train = opened.enter_context(ShardedSet.read(url, "train"))
            validation = opened.enter_context(ShardedSet.read(url, "validation"))
            for what in ("recipe", "classes"):
                if getattr(train.head, what) != getattr(validation.head, what):
                    raise InputError(f"{url}: its splits have other {what}; convert the set again")
            opened.pop_all()
            return cls(train, validation)

    def __len__(self) -> int:
        return len(self.train)

    @property
    def classes(self) -> tuple[str, ...]:
        """What labels count."""
        return self.train.classes

    @property
    def digest(self) -> str:
        """A hash of what the shards were made of."""
        return self.train.head.digest

    @property
    def recipe(self) -> GridRecipe:
        """How the grids were made."""
        recipe = recipe_from_dict(self.train.head.recipe)
        assert isinstance(recipe, GridRecipe)
        return recipe

    def data(self, settings: TrainingSettings, device: torch.device, world: int) -> TrainingData:
        """What a run is shown.

        Args:
            settings: Of the run.
            device: Where the network runs.
            world: Processes that share the work.

        Raises:
            InputError: A class has no grid that trains, or there is no batch for each process.
        """
        batches = ShardBatches(self.train, settings)
        counts = self.train.counts()
        if missing := [name for name, count in counts.items() if not count]:
            raise InputError(f"no training grid of class {', '.join(missing)}; complete the set")
        if settings.batch_size % world:
            raise InputError(
                f"--batch-size {settings.batch_size}: {world} processes share each batch of a "
                "sharded set; take a multiple of that"
            )
        if not batches.steps(world):
            raise InputError(
                f"{len(self.train)} grids in {self.train.groups} row groups: too few for a batch "
                f"of {settings.batch_size} in {world} processes; take fewer processes, a smaller "
                "--batch-size, or convert the set with a smaller --shard-size"
            )
        examiner = ShardExaminer(self.validation, device)
        weights = class_weights(list(counts.values()), settings.balance)
        return TrainingData(
            self.classes, self.digest, len(self.train), [], len(self.validation), batches,
            examiner, weights,
        )  # fmt: skip

    def close(self) -> None:
        """Let go of all files."""
        self.train.close()
        self.validation.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class ShardBatches:
    """Grids of shards, shuffled, in bounded memory; see `Batches`.

    Args:
        shards: What trains.
        settings: Of the run.
    """

    def __init__(self, shards: ShardedSet, settings: TrainingSettings) -> None:
        self._shards, self._settings = shards, settings
        self._one_hot = np.eye(len(shards.classes), dtype=np.float32)

    def steps(self, world: int) -> int:
        """Whole batches in an epoch."""
        return self._shards.steps(self._settings.batch_size, world)

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """See `Batches.of_epoch`."""
        size, seed = self._settings.batch_size, self._settings.seed * 1_000_003 + epoch
        for rows in self._shards.batches(size, seed, first, rank, world):
            yield (self._shards.unpacked(rows),), self._one_hot[rows.labels]


def class_weights(counts: list[int], balance: float) -> tuple[float, ...]:
    """Weights of the classes in the loss; their mean over all grids is 1.

    A stream draws all grids equally often. The weights have the effect that drawing classes
    equally often would have.

    Args:
        counts: Grids of each class.
        balance: 1 gives all classes the same weight in all, 0 all grids.
    """
    weights = (1.0 / np.array(counts)) ** balance
    return tuple((weights * np.sum(counts) / (weights * counts).sum()).tolist())
