"""Our network: the grid as a panorama, with the radius as channels.

Planar convolutions run over (azimuth, height) and see all radii at once, which costs a fifteenth
of spatial ones. Strides shorten the height alone. Then each azimuth becomes one feature vector,
and circular convolutions relate front, sides and back before row-wise pooling.
"""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from circumspect.nets.azimuth import RowWisePool, wrap


class PanoramaConvolution(nn.Module):
    """3x3 convolution and batch norm on (n, c, azimuth, height), wrapped in azimuth."""

    def __init__(self, inputs: int, outputs: int, height_stride: int = 1) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(
            inputs, outputs, 3, stride=(1, height_stride), padding=(0, 1), bias=False
        )
        self.norm = nn.BatchNorm2d(outputs)

    def forward(self, features: Tensor) -> Tensor:
        """Convolve."""
        return self.norm(self.convolution(wrap(features, 1, dim=2)))


class PanoramaBlock(nn.Module):
    """Two convolutions beside a shortcut."""

    def __init__(self, inputs: int, outputs: int, height_stride: int) -> None:
        super().__init__()
        self.first = PanoramaConvolution(inputs, outputs, height_stride)
        self.second = PanoramaConvolution(outputs, outputs)
        self.shortcut = nn.Identity()
        if inputs != outputs or height_stride != 1:
            self.shortcut = nn.Sequential(
                nn.AvgPool2d((1, height_stride)),
                nn.Conv2d(inputs, outputs, 1, bias=False),
                nn.BatchNorm2d(outputs),
            )

    def forward(self, features: Tensor) -> Tensor:
        """Add what the convolutions find to the shortcut."""
        inner = self.second(functional.relu(self.first(features)))
        return functional.relu(self.shortcut(features) + inner)


class CircleBlock(nn.Module):
    """Depthwise circular convolution over (n, c, azimuth), then a small network a cell."""

    def __init__(self, channels: int, kernel: int) -> None:
        super().__init__()
        self.margin = kernel // 2
        self.along = nn.Conv1d(channels, channels, kernel, groups=channels, bias=False)
        self.norm = nn.BatchNorm1d(channels)
        self.expand = nn.Conv1d(channels, 2 * channels, 1)
        self.reduce = nn.Conv1d(2 * channels, channels, 1)
        # Starts as the identity.
        nn.init.zeros_(self.reduce.weight)
        assert self.reduce.bias is not None
        nn.init.zeros_(self.reduce.bias)

    def forward(self, features: Tensor) -> Tensor:
        """Mix along the circle."""
        mixed = self.norm(self.along(wrap(features, self.margin, dim=2)))
        return features + self.reduce(functional.gelu(self.expand(mixed)))


class Panorama(nn.Module):
    """See the file's text.

    Args:
        classes: How many.
        shape: Cells along (radius, azimuth, height).
        widths: Channels of the planar blocks; the height halves from one to the next.
        circle: Channels along the circle.
        circle_blocks: Circular blocks.
        kernel: Their reach, in azimuth cells.
        dropout: Before each of the two last layers.
    """

    def __init__(
        self,
        classes: int,
        shape: tuple[int, int, int] = (32, 32, 32),
        widths: tuple[int, ...] = (32, 64, 128),
        circle: int = 256,
        circle_blocks: int = 2,
        kernel: int = 9,
        dropout: float = 0.3,
    ) -> None:
        super().__init__()
        radii, _, heights = shape
        self.stem = PanoramaConvolution(radii, widths[0])
        inputs = (widths[0], *widths[:-1])
        self.blocks = nn.Sequential(
            *(
                PanoramaBlock(i, o, height_stride=2 if depth else 1)
                for depth, (i, o) in enumerate(zip(inputs, widths, strict=True))
            )
        )
        rows = heights >> (len(widths) - 1)
        self.column = nn.Sequential(
            nn.Conv1d(widths[-1] * rows, circle, 1, bias=False), nn.BatchNorm1d(circle), nn.ReLU()
        )
        self.circle = nn.Sequential(
            *(CircleBlock(circle, kernel) for _ in range(circle_blocks)), nn.BatchNorm1d(circle)
        )
        self.pool = RowWisePool()
        self.head = nn.Sequential(
            nn.Dropout(dropout),
            nn.Linear(2 * circle, 256),
            nn.BatchNorm1d(256),
            nn.ReLU(),
            nn.Dropout(dropout),
            nn.Linear(256, classes),
        )

    def forward(self, grids: Tensor) -> Tensor:
        """Logits.

        Args:
            grids: (n, 1, radius, azimuth, height), 1 where occupied.

        Returns:
            (n, classes).
        """
        features = functional.relu(self.stem(grids.squeeze(1)))
        features = self.blocks(features)
        columns = self.column(features.permute(0, 1, 3, 2).flatten(1, 2))
        return self.head(self.pool(self.circle(columns)))
