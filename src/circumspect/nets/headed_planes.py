"""`planes` that also learns which way an object faces.

Naming the orientation beside the class helps the class (ORION, Sedaghat et al. 2017). Here the
orientation is a distribution over the azimuth cells. It turns with the object, and so do the
columns that it weighs: their weighted sum joins what is pooled, and the answer forgets the turn.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import torch
from torch import Tensor, nn

from circumspect.nets.planes import Planes


class Headed(NamedTuple):
    """What the network says in training.

    Attributes:
        logits: (n, classes).
        heading: (n, azimuth) logits of the cell that the object's 0° lies in.
    """

    logits: Tensor
    heading: Tensor


class HeadedPlanes(Planes):
    """See the file's text; the arguments are those of `Planes`.

    Narrow enough that a committee of three has less than 2 M parameters.
    """

    summaries: ClassVar[int] = 3

    def __init__(
        self,
        classes: int,
        shape: tuple[int, int, int] = (32, 32, 32),
        widths: tuple[int, ...] = (24, 48, 96),
        circle: int = 112,
        hidden: int = 160,
        dropout: float = 0.4,
        **others: Any,
    ) -> None:
        super().__init__(classes, shape, widths, circle, hidden=hidden, dropout=dropout, **others)
        self.facing = nn.Conv1d(circle, 1, 1)

    def forward(self, grids: Tensor, context: Tensor | None = None) -> Any:  # noqa: ARG002
        """Logits.

        Args:
            grids: (n, 1, radius, azimuth, height), 1 where occupied.
            context: None; this network takes none.

        Returns:
            (n, classes); in training `Headed`.
        """
        columns = self.columns(grids)
        heading = self.facing(columns).squeeze(1)
        front = (columns * heading.softmax(1).unsqueeze(1)).sum(2)
        logits = self.head(torch.cat([self.pool(columns), front], 1))
        return Headed(logits, heading) if self.training else logits
