"""Layers that treat the azimuth as a circle.

A roll of the input along the azimuth rolls the output of every layer equally (equivariance).
Row-wise pooling removes the roll: the result is exactly invariant to rotations by whole cells.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn


def wrap(features: Tensor, margin: int, dim: int) -> Tensor:
    """Pad a circular axis at both ends.

    Uses slices instead of circular padding, because they export to ONNX unchanged.

    Args:
        features: Features of any shape.
        margin: Number of cells to add at each end, at most the axis' length.
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
    """Row-wise max pooling (RWMP) over the azimuth, concatenated with the mean.

    Maps (n, c, azimuth) to (n, 2 c).
    """

    def forward(self, features: Tensor) -> Tensor:
        """Pool over the last axis."""
        return torch.cat([features.amax(-1), features.mean(-1)], 1)
