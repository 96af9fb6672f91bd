"""The paper's network (section 3.3, Table 1).

S. Moon, H. Kim, B. Lee, "View-point Invariant 3D Classification for Mobile Robots Using a
Convolutional Neural Network", International Journal of Control, Automation and Systems, 2018.
Nothing is padded or wrapped: the azimuth shrinks with the other axes, and invariance is only near.
"""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor, nn

from circumspect.errors import InputError
from circumspect.nets.quick_dropout import QuickDropout

FILTERS = ((3, 16), (5, 32), (3, 64), (3, 128))
"""Kernel and channels of the convolutions."""
WIDTHS = (1024, 512)
DROPOUT = 0.4
AZIMUTH = 3
"""Axis of (n, channels, radius, azimuth, height)."""


class RowWiseMaxPool(nn.Module):
    """RWMP: the largest value along the azimuth for each radius, height and channel."""

    def forward(self, features: Tensor) -> Tensor:
        """(n, c, radius, azimuth, height) to (n, c, radius, 1, height)."""
        return torch.amax(features, AZIMUTH, keepdim=True)


class Moon2018(nn.Module):
    """See the file's text.

    Args:
        classes: How many.
        shape: Of the grid: (radius, azimuth, height), or (x, y, z), where the rows lie along y.
        pool: "rwmp", or "max", pooling by 2 x 2 x 2 with stride 2, in its place.

    Raises:
        InputError: Too few cells.
    """

    def __init__(
        self,
        classes: int,
        shape: tuple[int, int, int] = (32, 32, 32),
        pool: Literal["rwmp", "max"] = "rwmp",
    ) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels = 1
        for kernel, outputs in FILTERS:
            layers += [nn.Conv3d(channels, outputs, kernel), nn.ReLU(), QuickDropout(DROPOUT)]
            channels = outputs
        layers.append(RowWiseMaxPool() if pool == "rwmp" else nn.MaxPool3d(2))
        shrunk = [cells - sum(kernel - 1 for kernel, _ in FILTERS) for cells in shape]
        if min(shrunk) < (least := 1 if pool == "rwmp" else 2):
            needed = max(shape) - max(shrunk) + least
            raise InputError(f"moon2018 needs {needed} cells or more along each axis, not {shape}")
        radius, azimuth, height = shrunk if pool == "rwmp" else [cells // 2 for cells in shrunk]
        inputs = channels * radius * height * (1 if pool == "rwmp" else azimuth)
        layers.append(nn.Flatten())
        for outputs in WIDTHS:
            layers += [nn.Linear(inputs, outputs), nn.ReLU(), QuickDropout(DROPOUT)]
            inputs = outputs
        self.layers = nn.Sequential(*layers, nn.Linear(inputs, classes))

    def forward(self, grids: Tensor) -> Tensor:
        """Logits.

        Args:
            grids: (n, 1, *shape), 1 where occupied.

        Returns:
            (n, classes).
        """
        return self.layers(grids)
