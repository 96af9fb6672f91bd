"""PointNet: C. Qi, H. Su, K. Mo, L. Guibas, "PointNet: Deep Learning on Point Sets for 3D
Classification and Segmentation", CVPR 2017.
"""

from __future__ import annotations

import itertools

import torch
from torch import Tensor, nn


class Transform(nn.Module):
    """A matrix that the points themselves choose, near the identity at first.

    Args:
        size: Rows and columns.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self.size = size
        self.each = _shared(size, 64, 128, 1024)
        self.all = nn.Sequential(_hidden(1024, 512), _hidden(512, 256), nn.Linear(256, size * size))
        last = self.all[-1]
        assert isinstance(last, nn.Linear)
        nn.init.zeros_(last.weight)
        nn.init.zeros_(last.bias)

    def forward(self, features: Tensor) -> Tensor:
        """(n, size, m) features of points to (n, size, m), each multiplied by the matrix."""
        chosen = self.all(torch.amax(self.each(features), 2)).view(-1, self.size, self.size)
        matrix = chosen + torch.eye(self.size, device=features.device, dtype=features.dtype)
        return matrix @ features


class PointNet(nn.Module):
    """Every point by itself, the largest of each feature over the points, and a classifier.

    Args:
        classes: How many.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.turn = Transform(3)
        self.first = _shared(3, 64, 64)
        self.align = Transform(64)
        self.second = _shared(64, 64, 128, 1024)
        self.head = nn.Sequential(
            _hidden(1024, 512), _hidden(512, 256), nn.Dropout(0.3), nn.Linear(256, classes)
        )

    def forward(self, points: Tensor) -> Tensor:
        """Logits.

        Args:
            points: (n, m, 3).

        Returns:
            (n, classes).
        """
        features = self.first(self.turn(points.transpose(1, 2)))
        features = self.second(self.align(features))
        return self.head(torch.amax(features, 2))


def _shared(*widths: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for inputs, outputs in itertools.pairwise(widths):
        layers += [nn.Conv1d(inputs, outputs, 1), nn.BatchNorm1d(outputs), nn.ReLU()]
    return nn.Sequential(*layers)


def _hidden(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, outputs), nn.BatchNorm1d(outputs), nn.ReLU())
