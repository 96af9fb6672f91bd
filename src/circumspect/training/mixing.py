"""Blends of two objects (mixup, Zhang et al. 2018)."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

BLEND = 0.4
"""Both parameters of the Beta distribution of the share."""


def mixed(grids: Tensor, targets: Tensor, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
    """Blend each object with another of the batch (mixup); it keeps the larger share.

    Args:
        grids: (b, 1, *shape).
        targets: (b, c).
        rng: Draws the share and the partners.

    Returns:
        Both, blended alike.
    """
    share = rng.beta(BLEND, BLEND)
    share = max(share, 1 - share)
    other = torch.from_numpy(rng.permutation(len(grids))).to(grids.device)
    return torch.lerp(grids[other], grids, share), torch.lerp(targets[other], targets, share)
