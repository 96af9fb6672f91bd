"""DeepPano: B. Shi, S. Bai, Z. Zhou, X. Bai, "DeepPano: Deep Panoramic Representation for 3-D Shape
Recognition", IEEE Signal Processing Letters 22 (12), 2015.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.nets.azimuth import wrap
from circumspect.nets.rendering import panorama

AZIMUTHS, HEIGHTS = 128, 64
WIDTHS = (32, 64, 128, 256)
MARGIN = 2
"""Margin of the 5 x 5 kernels."""


class DeepPano(nn.Module):
    """Convolutions and pooling on a panorama, then row-wise max pooling along the azimuth.

    Args:
        classes: Number of classes.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        inputs = (1, *WIDTHS[:-1])
        size = 2 * MARGIN + 1
        self.convolutions = nn.ModuleList(
            nn.Conv2d(i, o, size, padding=(0, MARGIN)) for i, o in zip(inputs, WIDTHS, strict=True)
        )
        self.norms = nn.ModuleList(nn.BatchNorm2d(o) for o in WIDTHS)
        self.head = nn.Sequential(
            nn.Dropout(0.5),
            nn.Linear(WIDTHS[-1] * (HEIGHTS >> len(WIDTHS)), 512),
            nn.BatchNorm1d(512),
            nn.ReLU(),
            nn.Dropout(0.5),
            nn.Linear(512, classes),
        )

    def forward(self, points: Tensor) -> Tensor:
        """Logits.

        Args:
            points: (n, m, 3) relative to the axis.

        Returns:
            (n, classes).
        """
        image = panorama(points, AZIMUTHS, HEIGHTS)
        for convolution, norm in zip(self.convolutions, self.norms, strict=True):
            image = functional.relu(norm(convolution(wrap(image, MARGIN, 2))))
            image = functional.max_pool2d(image, 2)
        rows = torch.amax(image, 2)
        return self.head(rows.flatten(1))
