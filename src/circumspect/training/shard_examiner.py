"""How well the averaged weights do on the validation split of a sharded set."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.datasets.shard_file import Rows
from circumspect.datasets.sharded_set import ShardedSet

GRIDS_AT_ONCE = 64


class ShardExaminer:
    """Measures a network on grids of complete objects at 0°, see `Examiner`.

    Args:
        shards: Held back.
        device: Where the network runs.
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
        """(n, c) of grids, each the mean over its views."""
        grids = torch.from_numpy(self._shards.unpacked(rows))
        count, views = grids.shape[:2]
        flat = grids.reshape(count * views, 1, *grids.shape[2:])
        parts = [net(part.to(self._device).float()) for part in flat.split(GRIDS_AT_ONCE)]
        return torch.cat([part.float().cpu() for part in parts]).view(count, views, -1).mean(1)
