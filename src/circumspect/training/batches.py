"""Training batches, resumable at any step of an epoch, and mixup of two objects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from circumspect.training.draws import draw_epoch
from circumspect.training.settings import TrainingSettings

Batch = tuple[tuple[NDArray[Any], ...], NDArray[np.float32]]
"""Inputs of b rows, with contexts if the network takes them, and (b, c) targets."""
BLEND = 0.4
"""Both parameters of the Beta distribution of the mixing weight."""


class Batches(Protocol):
    """Batches of training objects; a step of an epoch is reproducible."""

    def steps(self, world: int) -> int:
        """Number of batches in an epoch that `world` processes share."""
        ...

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """A process' part of each batch.

        Args:
            epoch: Number of the epoch, from 0.
            first: First step.
            rank: Number of this process.
            world: Number of processes.
        """
        ...


class Samples(Protocol):
    """Inputs of training objects under one index."""

    epoch: int
    """Number of objects drawn per epoch."""
    chances: NDArray[np.float64]
    """(n,) probability of each object; they sum to 1."""
    targets: NDArray[np.float32]
    """(n, c) one-hot targets."""

    def inputs(
        self, chosen: NDArray[np.int64], replicas: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[NDArray[Any], ...]:
        """The inputs of chosen objects.

        Args:
            chosen: (b,) indices.
            replicas: (b,) the variant of each.
            rng: Random generator of the batch.

        Returns:
            Arrays of b rows: the inputs, and contexts if the network takes them.
        """
        ...


class DrawnBatches:
    """Randomly drawn objects from memory; see `Batches`.

    Args:
        samples: The training objects.
        settings: Settings of the run.
    """

    def __init__(self, samples: Samples, settings: TrainingSettings) -> None:
        self.samples = samples
        self._settings = settings

    def steps(self, world: int) -> int:  # noqa: ARG002 - processes share each batch
        """Number of whole batches in an epoch, at least one."""
        return max(1, self.samples.epoch // self._settings.batch_size)

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """See `Batches.of_epoch`."""
        settings, samples = self._settings, self.samples
        rng = np.random.default_rng([settings.seed, epoch])
        draws = draw_epoch(samples.chances, samples.epoch, rng)
        replicas = rng.integers(settings.max_replicas, size=len(draws))
        for step in range(first, self.steps(world)):
            whole = slice(step * settings.batch_size, (step + 1) * settings.batch_size)
            mine = slice(rank, None, world)
            chosen = draws[whole][mine]
            rng = np.random.default_rng([settings.seed, epoch, step, 1])
            inputs = samples.inputs(chosen, replicas[whole][mine], rng)
            yield inputs, samples.targets[chosen]


def mixed(tensors: Sequence[Tensor], rng: np.random.Generator) -> list[Tensor]:
    """Mix each object with another one of the batch (mixup); the object has the larger weight.

    Args:
        tensors: Inputs and targets, each of b rows.
        rng: Draws the weight and the partners.

    Returns:
        The tensors, all mixed in the same way.
    """
    share = rng.beta(BLEND, BLEND)
    share = max(share, 1 - share)
    other = torch.from_numpy(rng.permutation(len(tensors[0]))).to(tensors[0].device)
    return [torch.lerp(tensor[other], tensor, share) for tensor in tensors]
