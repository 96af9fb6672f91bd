"""A small multi-view network: H. Su, S. Maji, E. Kalogerakis, E. Learned-Miller, "Multi-view
Convolutional Neural Networks for 3D Shape Recognition", ICCV 2015.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from circumspect.nets.rendering import depth_images

VIEWS, SIZE, ELEVATION = 12, 64, math.radians(30.0)
WIDTHS = (16, 32, 64, 128)


class MultiView(nn.Module):
    """One network for every view, max pooling over the views, and a classifier.

    Args:
        classes: Number of classes.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        inputs = 1
        for outputs in WIDTHS:
            layers += [
                nn.Conv2d(inputs, outputs, 3, padding=1, bias=False),
                nn.BatchNorm2d(outputs),
                # Pooling first leaves a quarter of the work for the ReLU, with the same result.
                nn.MaxPool2d(2),
                nn.ReLU(),
            ]
            inputs = outputs
        self.view = nn.Sequential(*layers, nn.Flatten())
        side = SIZE >> len(WIDTHS)
        self.head = nn.Sequential(
            nn.Dropout(0.5),
            nn.Linear(WIDTHS[-1] * side * side, 256),
            nn.BatchNorm1d(256),
            nn.ReLU(),
            nn.Dropout(0.5),
            nn.Linear(256, classes),
        )

    def forward(self, points: Tensor) -> Tensor:
        """Logits.

        Args:
            points: (n, m, 3) relative to the axis.

        Returns:
            (n, classes).
        """
        images = depth_images(points, VIEWS, SIZE, ELEVATION)
        features = self.view(images.reshape(-1, 1, SIZE, SIZE))
        return self.head(torch.amax(features.view(-1, VIEWS, features.shape[-1]), 1))
