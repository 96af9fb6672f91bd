"""Layers that treat the azimuth as the circle it is.

A roll of the input along the azimuth rolls the output of every layer here by as much, and
row-wise pooling then forgets the roll: the answer is exactly the same for turns by whole cells.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn


def wrap(features: Tensor, margin: int, dim: int) -> Tensor:
    """Continue a circular axis at both ends.

    Explicit slices rather than circular padding: they export to ONNX as they are.

    Args:
        features: Any shape.
        margin: Cells to add at each end, at most the axis' length.
        dim: The circular axis.

    Returns:
        The features, `2 * margin` longer along `dim`.
    """
    if margin == 0:
        return features
    length = features.shape[dim]
    tail = features.narrow(dim, length - margin, margin)
    return torch.cat([tail, features, features.narrow(dim, 0, margin)], dim)


class RowWisePool(nn.Module):
    """Row-wise max pooling (RWMP) over the azimuth, with the mean beside it.

    (n, c, azimuth) to (n, 2 c).
    """

    def forward(self, features: Tensor) -> Tensor:
        """Pool over the last axis."""
        return torch.cat([features.amax(-1), features.mean(-1)], 1)
