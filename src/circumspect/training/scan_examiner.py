"""How well a network names simulated scans of objects that were held back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces
from circumspect.datasets.scanned_inputs import ScannedInputs
from circumspect.evaluation.accuracy import mean_class_accuracy
from circumspect.nets.state_channels import state_channels

BATCH = 64


class ScanExaminer:
    """Measures a network on scans.

    Args:
        sources: Scans and the objects that they are of.
        classes: Of the network's outputs, "other" last.
        device: Where the network runs.
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
        """Mean-class and instance accuracy over the classes, and the loss over all."""
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
            if grids.recipe.takes_context:
                shown = [state_channels(inputs), torch.from_numpy(contexts[part])]
            found.append(net(*(one.to(self._device) for one in shown)).float().cpu())
        return torch.cat(found)
