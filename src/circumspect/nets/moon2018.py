"""The network of the paper (section 3.3, Table 1).

S. Moon, H. Kim, B. Lee, "View-point Invariant 3D Classification for Mobile Robots Using a
Convolutional Neural Network", International Journal of Control, Automation and Systems, 2018.
Convolutions have no padding and do not wrap: the azimuth shrinks like the other axes, so that
invariance is approximate.

On a CPU, PyTorch draws dropout masks one by one, 10 ns each, which takes as long as the
convolutions of this network. Here one 64-bit random number yields four mask values.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.errors import InputError

FILTERS = ((3, 16), (5, 32), (3, 64), (3, 128))
"""Kernel and channels of the convolutions."""
WIDTHS = (1024, 512)
DROPOUT = 0.4
AZIMUTH = 3
"""Index of the azimuth in (n, channels, radius, azimuth, height)."""
HALF = 2**15
"""Dropout compares 16-bit numbers from -HALF to HALF - 1."""


class QuickDropout(nn.Module):
    """Fast `torch.nn.Dropout` for CPUs, with the probability rounded to 1/65536.

    Torch's generator seeds every call, so that `torch.manual_seed` makes it reproducible.

    Args:
        p: Probability that a value becomes zero.
    """

    def __init__(self, p: float) -> None:
        super().__init__()
        self.p = p

    def forward(self, features: Tensor) -> Tensor:
        """Zero each value with probability `p` and scale the others by 1/(1 - p), in training."""
        if not self.training or self.p == 0 or features.device.type != "cpu":
            return functional.dropout(features, self.p, self.training)
        scale = 1 / (1 - self.p) if self.p < 1 else 0.0
        return features * (_dropout_mask(features, self.p) * scale)


def _dropout_mask(features: Tensor, p: float) -> Tensor:
    """Mask of 1 with probability 1 - p, else 0, with the features' type and memory layout."""
    count = features.numel()
    seed = int(torch.randint(2**62, ()))
    drawn = np.random.PCG64(seed).random_raw(-(-count // 4)).view(np.int16)[:count]
    kept = torch.from_numpy(drawn) >= round(p * 2 * HALF) - HALF
    mask = torch.empty_like(features)
    # The order of the values in memory does not matter.
    mask.as_strided((count,), (1,)).copy_(kept)
    return mask


class RowWiseMaxPool(nn.Module):
    """RWMP: the largest value along the azimuth for each radius, height and channel."""

    def forward(self, features: Tensor) -> Tensor:
        """Pool (n, c, radius, azimuth, height) to (n, c, radius, 1, height)."""
        return torch.amax(features, AZIMUTH, keepdim=True)


class Moon2018(nn.Module):
    """The network of the paper; see the module's docstring.

    Args:
        classes: Number of classes.
        shape: Shape of the grid: (radius, azimuth, height), or (x, y, z) with rows along y.
        pool: "rwmp", or "max" for 2 x 2 x 2 max pooling with stride 2.

    Raises:
        InputError: The grid has too few cells.
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
