"""PointMLP in its small form, PointMLP-elite: X. Ma, C. Qin, H. You, H. Ran, Y. Fu, "Rethinking
Network Design and Local Geometry in Point Cloud: A Simple Residual MLP Framework", ICLR 2022.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

NEIGHBOURS = 24
"""Neighbours of each anchor, itself included."""
EMBEDDED = 32
STAGES = ((64, 1), (128, 1), (256, 2), (256, 1))
"""Features of each stage, and its residual blocks before and after the pooling."""
BOTTLENECK = 4
"""A residual block divides the number of features by this."""
MIN_SPREAD = 1e-5


class PointMLP(nn.Module):
    """Anchors gather the features of their neighbours; each of four stages halves the points.

    The anchors of a stage are the first half of its points. In the paper they are a farthest point
    sample. They are here as well if the points are in farthest-first order, since every prefix is
    such a sample.

    Args:
        classes: Number of classes.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.embedding = _hidden(3, EMBEDDED)
        stages: list[nn.Module] = []
        inputs = EMBEDDED
        for width, blocks in STAGES:
            stages.append(PointMlpStage(inputs, width, blocks))
            inputs = width
        self.stages = nn.ModuleList(stages)
        self.head = nn.Sequential(
            _hidden(inputs, 512, bias=True),
            nn.Dropout(0.5),
            _hidden(512, 256, bias=True),
            nn.Dropout(0.5),
            nn.Linear(256, classes),
        )

    def forward(self, points: Tensor) -> Tensor:
        """Logits.

        Args:
            points: (n, m, 3), the first half farthest-first; m at least 8 times `NEIGHBOURS`.

        Returns:
            (n, classes).
        """
        n, m, _ = points.shape
        features = self.embedding(points.reshape(n * m, 3)).view(n, m, -1)
        for stage in self.stages:
            features = stage(points, features)
            points = points[:, : features.shape[1]]
        return self.head(features.max(1).values)


class PointMlpStage(nn.Module):
    """Geometric affine module, residual blocks, pooling over neighbours, residual blocks.

    Args:
        inputs: Features of a point.
        width: Features of an anchor.
        blocks: Residual blocks before the pooling, and after it.
    """

    def __init__(self, inputs: int, width: int, blocks: int) -> None:
        super().__init__()
        self.alpha = nn.Parameter(torch.ones(inputs))
        self.beta = nn.Parameter(torch.zeros(inputs))
        self.of_neighbour = nn.Linear(inputs, width, bias=False)
        self.of_anchor = nn.Linear(inputs, width, bias=False)
        self.norm = nn.BatchNorm1d(width)
        self.before = nn.Sequential(*(Residual(width) for _ in range(blocks)))
        self.after = nn.Sequential(*(Residual(width) for _ in range(blocks)))

    def forward(self, points: Tensor, features: Tensor) -> Tensor:
        """Features of the anchors.

        Args:
            points: (n, m, 3), the anchors first; m at least `NEIGHBOURS`.
            features: (n, m, inputs).

        Returns:
            (n, m // 2, width).
        """
        n, m, _ = points.shape
        anchors = m // 2
        near = nearest(points, anchors)
        grouped = self.first_layer(features, near).reshape(n * anchors * NEIGHBOURS, -1)
        grouped = self.before(functional.relu(self.norm(grouped), inplace=True))
        pooled = grouped.view(n * anchors, NEIGHBOURS, -1).max(1).values
        return self.after(pooled).view(n, anchors, -1)

    def first_layer(self, features: Tensor, near: Tensor) -> Tensor:
        """The geometric affine module and the layer after it.

        For neighbour j of anchor i the result is W1 (α (f_j - f_i) / σ + β) + W2 f_i, with α and β
        per feature and σ from `spread`. It is linear in f_j, so that W1 is applied once to every
        point and not to every neighbour of every anchor.

        Args:
            features: (n, m, inputs).
            near: (n, anchors, NEIGHBOURS) indices of points.

        Returns:
            (n, anchors, NEIGHBOURS, width).
        """
        anchors = features[:, : near.shape[1]]
        scale = self.alpha / spread(features, near)[:, None, None]
        own = self.of_anchor(anchors) + self.of_neighbour(self.beta - scale * anchors)
        return chosen(self.of_neighbour(scale * features), near) + own.unsqueeze(2)


class Residual(nn.Module):
    """A residual block of two layers with a bottleneck.

    Args:
        width: Number of features.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.narrow = _hidden(width, width // BOTTLENECK)
        self.wide = nn.Sequential(
            nn.Linear(width // BOTTLENECK, width, bias=False), nn.BatchNorm1d(width)
        )

    def forward(self, features: Tensor) -> Tensor:
        """(n, width) to (n, width)."""
        # In place, because these are the largest arrays and memory limits training on a CPU.
        return functional.relu(self.wide(self.narrow(features)).add_(features), inplace=True)


def nearest(points: Tensor, anchors: int) -> Tensor:
    """The nearest points of each anchor.

    Args:
        points: (n, m, 3), the anchors first; m at least `NEIGHBOURS`.
        anchors: Number of anchors.

    Returns:
        (n, anchors, NEIGHBOURS) indices, unordered.
    """
    # No matrix product, because mixed precision would select other neighbours.
    x, y, z = (axis.unsqueeze(1) - axis[:, :anchors, None] for axis in points.unbind(2))
    away = x.square() + y.square() + z.square()
    return away.topk(NEIGHBOURS, largest=False, sorted=False).indices


def spread(features: Tensor, near: Tensor) -> Tensor:
    """Spread of the neighbours' features around their anchors' (σ in the paper).

    Args:
        features: (n, m, c), the anchors first.
        near: (n, anchors, NEIGHBOURS) indices of points.

    Returns:
        (n,) root mean square over anchors, neighbours and features; positive.
    """
    anchors = features[:, : near.shape[1]]
    beside = chosen(features, near) - anchors.unsqueeze(2)
    # The sum is positive even if all points coincide, because the root has no gradient at 0.
    return (beside.square().mean((1, 2, 3)) + MIN_SPREAD**2).sqrt()


def chosen(features: Tensor, near: Tensor) -> Tensor:
    """Gather the features of the indexed points.

    Args:
        features: (n, m, c).
        near: (n, a, k) indices of points.

    Returns:
        (n, a, k, c).
    """
    n, m, width = features.shape
    first = m * torch.arange(n, device=near.device)
    rows = (near + first[:, None, None]).flatten()
    return features.reshape(n * m, width).index_select(0, rows).view(*near.shape, width)


def _hidden(inputs: int, outputs: int, bias: bool = False) -> nn.Sequential:
    """A linear layer on rows of features, with a batch norm in place of the bias."""
    return nn.Sequential(
        nn.Linear(inputs, outputs, bias=bias), nn.BatchNorm1d(outputs), nn.ReLU(inplace=True)
    )
