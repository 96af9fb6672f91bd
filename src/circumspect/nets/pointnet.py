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
        self.each = Shared(size, 64, 128, 1024)
        self.all = nn.Sequential(_hidden(1024, 512), _hidden(512, 256), nn.Linear(256, size * size))
        last = self.all[-1]
        assert isinstance(last, nn.Linear)
        nn.init.zeros_(last.weight)
        nn.init.zeros_(last.bias)

    def forward(self, features: Tensor) -> Tensor:
        """(n, m, size) features of points to (n, m, size), each multiplied by the matrix."""
        chosen = self.all(_largest(self.each(features))).view(-1, self.size, self.size)
        matrix = chosen + torch.eye(self.size, device=features.device, dtype=features.dtype)
        return features @ matrix


class PointNet(nn.Module):
    """Every point by itself, the largest of each feature over the points, and a classifier.

    Args:
        classes: How many.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.turn = Transform(3)
        self.first = Shared(3, 64, 64)
        self.align = Transform(64)
        self.second = Shared(64, 64, 128, 1024)
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
        features = self.second(self.align(self.first(self.turn(points))))
        return self.head(_largest(features))


class Shared(nn.Module):
    """The same layers for every point.

    Points are rows, not columns: on a CPU that trains in two thirds of the time.
    """

    def __init__(self, *widths: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(*itertools.starmap(_hidden, itertools.pairwise(widths)))

    def forward(self, features: Tensor) -> Tensor:
        """(n, m, first width) to (n, m, last width)."""
        n, m, width = features.shape
        return self.layers(features.reshape(n * m, width)).view(n, m, -1)


def _largest(features: Tensor) -> Tensor:
    """(n, c) largest of (n, m, c); the gradient goes to one point, where `amax` shares it."""
    return features.max(1).values


def _hidden(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, outputs), nn.BatchNorm1d(outputs), nn.ReLU())
