"""PointNet: C. Qi, H. Su, K. Mo, L. Guibas, "PointNet: Deep Learning on Point Sets for 3D
Classification and Segmentation", CVPR 2017.
"""

from __future__ import annotations

import itertools

import torch
from torch import Tensor, nn


class Transform(nn.Module):
    """A learnt transform that depends on the points, initially near the identity.

    Args:
        size: Number of rows and columns.
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
        """Multiply the (n, m, size) features of points by the matrix."""
        chosen = self.all(_max_over_points(self.each(features))).view(-1, self.size, self.size)
        matrix = chosen + torch.eye(self.size, device=features.device, dtype=features.dtype)
        return features @ matrix


class PointNet(nn.Module):
    """Shared layers for every point, max pooling over the points, and a classifier.

    Args:
        classes: Number of classes.
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
        return self.head(_max_over_points(features))


class Shared(nn.Module):
    """Layers shared by all points.

    Points are rows, not columns, which reduces the training time on a CPU to two thirds.
    """

    def __init__(self, *widths: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(*itertools.starmap(_hidden, itertools.pairwise(widths)))

    def forward(self, features: Tensor) -> Tensor:
        """Map (n, m, first width) to (n, m, last width)."""
        n, m, width = features.shape
        return self.layers(features.reshape(n * m, width)).view(n, m, -1)


def _max_over_points(features: Tensor) -> Tensor:
    """(n, c) maximum of (n, m, c); the gradient goes to one point, whereas `amax` splits it."""
    return features.max(1).values


def _hidden(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, outputs), nn.BatchNorm1d(outputs), nn.ReLU())
