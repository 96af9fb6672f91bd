"""Training on a sharded set."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Self

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.classification import GridSpec, input_spec_from_dict
from circumspect.datasets.shard_file import Rows
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.errors import InputError
from circumspect.training.batches import Batch
from circumspect.training.settings import TrainingSettings
from circumspect.training.training_data import TrainingData

GRIDS_AT_ONCE = 64


class ShardExaminer:
    """Measures a network on grids of complete objects at 0°, see `Examiner`.

    Args:
        shards: The held-back split.
        device: Device of the network.
    """

    def __init__(self, shards: ShardedSet, device: torch.device) -> None:
        self._shards, self._device = shards, device

    def examine(self, net: nn.Module) -> dict[str, float]:
        """Mean-class accuracy, instance accuracy and loss."""
        net.eval()
        classes = len(self._shards.classes)
        hits, seen, loss = np.zeros(classes), np.zeros(classes), 0.0
        for rows in self._shards.in_order():
            logits, labels = self._logits(net, rows), torch.from_numpy(rows.labels.copy())
            correct = (logits.argmax(1) == labels).numpy()
            hits += np.bincount(rows.labels, correct, minlength=classes)
            seen += np.bincount(rows.labels, minlength=classes)
            loss += float(functional.cross_entropy(logits, labels, reduction="sum"))
        there = seen > 0
        return {
            "validation_accuracy": float((hits[there] / seen[there]).mean()),
            "validation_instance_accuracy": float(hits.sum() / seen.sum()),
            "validation_loss": loss / float(seen.sum()),
        }

    @torch.no_grad()
    def _logits(self, net: nn.Module, rows: Rows) -> Tensor:
        """(n, c) logits of grids, averaged over views."""
        grids = torch.from_numpy(self._shards.unpacked(rows))
        count, views = grids.shape[:2]
        flat = grids.reshape(count * views, 1, *grids.shape[2:])
        parts = [net(part.to(self._device).float()) for part in flat.split(GRIDS_AT_ONCE)]
        return torch.cat([part.float().cpu() for part in parts]).view(count, views, -1).mean(1)


class ShardedTraining:
    """The splits of a sharded set for a run.

    Attributes:
        train: The training split.
        validation: The split that was held back when the shards were made.
    """

    def __init__(self, train: ShardedSet, validation: ShardedSet) -> None:
        """Set the open splits; see `read`."""
        self.train, self.validation = train, validation

    @classmethod
    def read(cls, url: str | os.PathLike[str]) -> Self:
        """Open the training and the validation split.

        Args:
            url: The set, a folder or a URL.

        Raises:
            InputError: A shard is missing or broken, or the splits do not match.
            MissingExtraError: pyarrow or fsspec is not installed.
        """
        with ExitStack() as opened:
            train = opened.enter_context(ShardedSet.read(url, "train"))
            validation = opened.enter_context(ShardedSet.read(url, "validation"))
            for what in ("input_spec", "classes"):
                if getattr(train.head, what) != getattr(validation.head, what):
                    raise InputError(f"{url}: its splits differ in {what}; convert the set again")
            opened.pop_all()
            return cls(train, validation)

    def __len__(self) -> int:
        return len(self.train)

    @property
    def classes(self) -> tuple[str, ...]:
        """Class names in the order of the labels."""
        return self.train.classes

    @property
    def digest(self) -> str:
        """Hash of the source of the shards."""
        return self.train.head.digest

    @property
    def input_spec(self) -> GridSpec:
        """The input specification of the grids."""
        input_spec = input_spec_from_dict(self.train.head.input_spec)
        assert isinstance(input_spec, GridSpec)
        return input_spec

    def data(self, settings: TrainingSettings, device: torch.device, world: int) -> TrainingData:
        """The training data of a run.

        Args:
            settings: Settings of the run.
            device: Device of the network.
            world: Number of processes.

        Raises:
            InputError: A class has no training grid, or there is no batch for each process.
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
        """Close all files."""
        self.train.close()
        self.validation.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class ShardBatches:
    """Shuffled grids of shards in bounded memory; see `Batches`.

    Args:
        shards: The training split.
        settings: Settings of the run.
    """

    def __init__(self, shards: ShardedSet, settings: TrainingSettings) -> None:
        self._shards, self._settings = shards, settings
        self._one_hot = np.eye(len(shards.classes), dtype=np.float32)

    def steps(self, world: int) -> int:
        """Number of whole batches in an epoch."""
        return self._shards.steps(self._settings.batch_size, world)

    def of_epoch(self, epoch: int, first: int, rank: int, world: int) -> Iterator[Batch]:
        """See `Batches.of_epoch`."""
        size, seed = self._settings.batch_size, self._settings.seed * 1_000_003 + epoch
        for rows in self._shards.batches(size, seed, first, rank, world):
            yield (self._shards.unpacked(rows),), self._one_hot[rows.labels]


def class_weights(counts: list[int], balance: float) -> tuple[float, ...]:
    """Weights of the classes in the loss; their mean over all grids is 1.

    A stream draws all grids equally often. With a balance of 1 the weights have the effect of
    drawing all classes equally often.

    Args:
        counts: Number of grids per class.
        balance: 1 gives all classes the same total weight, 0 all grids.
    """
    weights = (1.0 / np.array(counts)) ** balance
    return tuple((weights * np.sum(counts) / (weights * counts).sum()).tolist())
