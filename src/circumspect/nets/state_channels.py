"""Encoding of cell states as channels."""

from __future__ import annotations

import torch
from torch import Tensor

from circumspect.grid.grid import FREE, OCCUPIED


def state_channels(states: Tensor) -> Tensor:
    """Encode occupied and free cells as two channels; unknown cells are 0 in both.

    Args:
        states: (n, 1, *shape) uint8.

    Returns:
        (n, 2, *shape) float32, 1 or 0.
    """
    return torch.cat([states == OCCUPIED, states == FREE], 1).float()
