"""VoxNet: D. Maturana and S. Scherer, "VoxNet: A 3D Convolutional Neural Network for Real-Time
Object Recognition", IROS 2015.
"""

from __future__ import annotations

from torch import Tensor, nn

from circumspect.errors import InputError

SLOPE = 0.1
"""Slope of the leaky rectifiers."""


class VoxNet(nn.Module):
    """Two convolutions, pooling and one hidden layer on a rectangular grid.

    Args:
        classes: Number of classes.
        shape: Cells along (x, y, z).

    Raises:
        InputError: The grid has too few cells.
    """

    def __init__(self, classes: int, shape: tuple[int, int, int] = (32, 32, 32)) -> None:
        super().__init__()
        left = [((cells - 5) // 2 + 1 - 2) // 2 for cells in shape]
        if min(left) < 1:
            raise InputError(f"voxnet needs 11 cells or more along each axis, not {shape}")
        self.layers = nn.Sequential(
            nn.Conv3d(1, 32, 5, stride=2),
            nn.LeakyReLU(SLOPE),
            nn.Dropout(0.2),
            nn.Conv3d(32, 32, 3),
            nn.LeakyReLU(SLOPE),
            nn.MaxPool3d(2),
            nn.Dropout(0.3),
            nn.Flatten(),
            nn.Linear(32 * left[0] * left[1] * left[2], 128),
            nn.ReLU(),
            nn.Dropout(0.4),
            nn.Linear(128, classes),
        )

    def forward(self, grids: Tensor) -> Tensor:
        """Logits.

        Args:
            grids: (n, 1, *shape), 1 where occupied.

        Returns:
            (n, classes).
        """
        return self.layers(grids)
