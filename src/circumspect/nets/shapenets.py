"""The classifier of 3D ShapeNets in its feed-forward form.

Z. Wu, S. Song, A. Khosla, F. Yu, L. Zhang, X. Tang, J. Xiao, "3D ShapeNets: A Deep Representation
for Volumetric Shapes", CVPR 2015.
"""

from __future__ import annotations

from torch import Tensor, nn

from circumspect.errors import InputError


class ShapeNets(nn.Module):
    """Three convolutions and two hidden layers on a rectangular grid.

    Args:
        classes: Number of classes.
        shape: Cells along (x, y, z).

    Raises:
        InputError: The grid has too few cells.
    """

    def __init__(self, classes: int, shape: tuple[int, int, int] = (32, 32, 32)) -> None:
        super().__init__()
        left = [(((cells - 6) // 2 + 1) - 5) // 2 + 1 - 3 for cells in shape]
        if min(left) < 1:
            raise InputError(f"3dshapenets needs 26 cells or more along each axis, not {shape}")
        self.layers = nn.Sequential(
            nn.Conv3d(1, 48, 6, stride=2),
            nn.ReLU(),
            nn.Conv3d(48, 160, 5, stride=2),
            nn.ReLU(),
            nn.Conv3d(160, 512, 4),
            nn.ReLU(),
            nn.Flatten(),
            nn.Dropout(0.5),
            nn.Linear(512 * left[0] * left[1] * left[2], 1200),
            nn.ReLU(),
            nn.Dropout(0.5),
            nn.Linear(1200, 4000),
            nn.ReLU(),
            nn.Dropout(0.5),
            nn.Linear(4000, classes),
        )

    def forward(self, grids: Tensor) -> Tensor:
        """Logits.

        Args:
            grids: (n, 1, *shape), 1 where occupied.

        Returns:
            (n, classes).
        """
        return self.layers(grids)
