"""Dropout whose coins are cheap.

PyTorch tosses one coin after the other on a CPU: 10 ns each, as much time as the convolutions of
the paper's network take. Here four come from one 64-bit number.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

HALF = 2**15
"""Coins are 16-bit numbers from -HALF to HALF - 1."""


class QuickDropout(nn.Module):
    """As `torch.nn.Dropout`, with the probability rounded to 1/65536, and quick on a CPU.

    Torch's generator seeds every call, so that `torch.manual_seed` makes it repeatable.

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
        return features * (_kept(features, self.p) * scale)


def _kept(features: Tensor, p: float) -> Tensor:
    """1 with probability 1 - p, else 0; of the features' type and layout in memory."""
    count = features.numel()
    seed = int(torch.randint(2**62, ()))
    drawn = np.random.PCG64(seed).random_raw(-(-count // 4)).view(np.int16)[:count]
    kept = torch.from_numpy(drawn) >= round(p * 2 * HALF) - HALF
    mask = torch.empty_like(features)
    # The order of the values in memory is as good as any.
    mask.as_strided((count,), (1,)).copy_(kept)
    return mask
