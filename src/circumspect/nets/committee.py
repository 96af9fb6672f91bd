"""Several networks that answer separately and are averaged."""

from __future__ import annotations

from collections.abc import Iterable

import torch
from torch import Tensor, nn


class Committee(nn.Module):
    """The mean of its members' logits.

    Each member learns from its own answer alone, so that their errors stay as independent as
    different initial weights make them; in training they are therefore told apart.

    Args:
        members: Networks with the same input and the same classes.
    """

    def __init__(self, members: Iterable[nn.Module]) -> None:
        super().__init__()
        self.members = nn.ModuleList(members)

    def forward(self, grids: Tensor) -> Tensor:
        """Logits.

        Args:
            grids: (n, 1, radius, azimuth, height), 1 where occupied.

        Returns:
            (n, classes); in training (n, members, classes).
        """
        answers = torch.stack([member(grids) for member in self.members], 1)
        return answers if self.training else answers.mean(1)
