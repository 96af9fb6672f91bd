"""The batches of an epoch, from any step on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.training.draws import draw_epoch
from circumspect.training.settings import TrainingSettings

Batch = tuple[tuple[NDArray[Any], ...], NDArray[np.float32]]
"""Inputs of b rows, with their contexts where the network takes them, and (b, c) targets."""


class Batches(Protocol):
    """Batches of training objects; the same step of the same epoch always has the same."""

    def steps(self, world: int) -> int:
        """Batches in an epoch that `world` processes share."""
        ...

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """A process' share of each batch.

        Args:
            epoch: From 0.
            first: Begin with this step.
            rank: Which process this is.
            world: How many there are.
        """
        ...


class Samples(Protocol):
    """Inputs of training objects under one index."""

    epoch: int
    """Draws an epoch."""
    chances: NDArray[np.float64]
    """(n,) chance of each object; they sum to 1."""
    targets: NDArray[np.float32]
    """(n, c) one-hot targets."""

    def inputs(
        self, chosen: NDArray[np.int64], replicas: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[NDArray[Any], ...]:
        """What the network is shown of chosen objects.

        Args:
            chosen: (b,) indices.
            replicas: (b,) the variant of each.
            rng: Of what is drawn for each batch.

        Returns:
            Arrays of b rows: the inputs, and their contexts where the network takes them.
        """
        ...


class DrawnBatches:
    """Objects drawn at random, all of which are in memory; see `Batches`.

    Args:
        samples: What is drawn from.
        settings: Of the run.
    """

    def __init__(self, samples: Samples, settings: TrainingSettings) -> None:
        self.samples = samples
        self._settings = settings

    def steps(self, world: int) -> int:  # noqa: ARG002 - processes share each batch
        """Whole batches in an epoch, at least one."""
        return max(1, self.samples.epoch // self._settings.batch_size)

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """See `Batches.of_epoch`."""
        settings, samples = self._settings, self.samples
        rng = np.random.default_rng([settings.seed, epoch])
        draws = draw_epoch(samples.chances, samples.epoch, rng)
        replicas = rng.integers(settings.most_replicas, size=len(draws))
        for step in range(first, self.steps(world)):
            whole = slice(step * settings.batch_size, (step + 1) * settings.batch_size)
            mine = slice(rank, None, world)
            chosen = draws[whole][mine]
            rng = np.random.default_rng([settings.seed, epoch, step, 1])
            inputs = samples.inputs(chosen, replicas[whole][mine], rng)
            yield inputs, samples.targets[chosen]
