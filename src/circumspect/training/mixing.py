"""Blends of two objects (mixup, Zhang et al. 2018)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

BLEND = 0.4
"""Both parameters of the Beta distribution of the share."""


def mixed(tensors: Sequence[Tensor], rng: np.random.Generator) -> list[Tensor]:
    """Blend each object with another of the batch (mixup); it keeps the larger share.

    Args:
        tensors: Inputs and targets, each of b rows.
        rng: Draws the share and the partners.

    Returns:
        All of them, blended alike.
    """
    share = rng.beta(BLEND, BLEND)
    share = max(share, 1 - share)
    other = torch.from_numpy(rng.permutation(len(tensors[0]))).to(tensors[0].device)
    return [torch.lerp(tensor[other], tensor, share) for tensor in tensors]
