"""Committees of trained networks, whose logits are averaged."""

from __future__ import annotations

from collections.abc import Iterable

import torch
from torch import Tensor, nn


class Committee(nn.Module):
    """The mean of its members' logits.

    Args:
        members: Networks with the same inputs and classes.
    """

    def __init__(self, members: Iterable[nn.Module]) -> None:
        super().__init__()
        self.members = nn.ModuleList(members)

    def forward(self, *inputs: Tensor) -> Tensor:
        """Logits.

        Args:
            inputs: Inputs of each member.

        Returns:
            (n, classes).
        """
        return torch.stack([member(*inputs) for member in self.members]).mean(0)
