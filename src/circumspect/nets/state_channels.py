"""The three states of a cell as channels."""

from __future__ import annotations

import torch
from torch import Tensor

from circumspect.grid.occupancy_grid import FREE, OCCUPIED


def state_channels(states: Tensor) -> Tensor:
    """Occupied and free cells; what is unknown is neither.

    Args:
        states: (n, 1, *shape) uint8.

    Returns:
        (n, 2, *shape) float32, 1 or 0.
    """
    return torch.cat([states == OCCUPIED, states == FREE], 1).float()
