"""Our network: the cylinder as two stacks of planes.

One branch sees the (azimuth, height) panorama with all radii as channels, the other the (azimuth,
radius) plan with all heights as channels. Planar convolutions cost a fraction of spatial ones, and
strides shorten height and radius alone. Then each azimuth becomes one feature vector; circular
convolutions relate front, sides and back before row-wise pooling.
"""

from __future__ import annotations

from typing import ClassVar

import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.errors import InputError
from circumspect.nets.azimuth import RowWisePool, wrap

CONTEXT_FEATURES = 48
"""What the numbers beside a grid become."""


class PlaneConvolution(nn.Module):
    """Convolution and batch norm on (n, c, azimuth, rows), wrapped in azimuth."""

    def __init__(self, inputs: int, outputs: int, kernel: int = 3, row_stride: int = 1) -> None:
        super().__init__()
        self.margin = kernel // 2
        self.convolution = nn.Conv2d(
            inputs, outputs, kernel, stride=(1, row_stride), padding=(0, self.margin), bias=False
        )
        self.norm = nn.BatchNorm2d(outputs)

    def forward(self, features: Tensor) -> Tensor:
        """Convolve."""
        return self.norm(self.convolution(wrap(features, self.margin, dim=2)))


class Shortcut(nn.Sequential):
    """Mean over neighbouring rows, 1 × 1 convolution, batch norm; both first steps as one."""

    def __init__(self, inputs: int, outputs: int, row_stride: int) -> None:
        super().__init__(
            nn.AvgPool2d((1, row_stride)),
            nn.Conv2d(inputs, outputs, 1, bias=False),
            nn.BatchNorm2d(outputs),
        )
        self.row_stride = row_stride

    def forward(self, input: Tensor) -> Tensor:
        """Shorten the rows and change the channels."""
        _, projection, norm = self
        assert isinstance(projection, nn.Conv2d)
        weight = projection.weight.expand(-1, -1, -1, self.row_stride) / self.row_stride
        return norm(functional.conv2d(input, weight, stride=(1, self.row_stride)))


class PlaneBlock(nn.Module):
    """Two convolutions beside a shortcut."""

    def __init__(self, inputs: int, outputs: int, row_stride: int) -> None:
        super().__init__()
        self.first = PlaneConvolution(inputs, outputs, row_stride=row_stride)
        self.second = PlaneConvolution(outputs, outputs)
        self.shortcut = nn.Identity()
        if inputs != outputs or row_stride != 1:
            self.shortcut = Shortcut(inputs, outputs, row_stride)

    def forward(self, features: Tensor) -> Tensor:
        """Add what the convolutions find to the shortcut."""
        inner = self.second(functional.relu(self.first(features)))
        return functional.relu(self.shortcut(features) + inner)


class PlaneBranch(nn.Module):
    """(n, channels, azimuth, rows) to wider channels of fewer rows.

    Attributes:
        features: Channels times rows of what comes out: numbers that describe an azimuth.
    """

    def __init__(self, channels: int, rows: int, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.stem = PlaneConvolution(channels, widths[0], kernel=5, row_stride=2)
        inputs = (widths[0], *widths[:-1])
        self.blocks = nn.Sequential(
            *(
                PlaneBlock(i, o, row_stride=2 if depth else 1)
                for depth, (i, o) in enumerate(zip(inputs, widths, strict=True))
            )
        )
        self.features = widths[-1] * (rows >> len(widths))

    def forward(self, planes: Tensor) -> Tensor:
        """Shorten each azimuth's row."""
        return self.blocks(functional.relu(self.stem(planes)))


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
        for parameter in self.reduce.parameters():
            nn.init.zeros_(parameter)

    def forward(self, features: Tensor) -> Tensor:
        """Mix along the circle."""
        mixed = self.norm(self.along(wrap(features, self.margin, dim=2)))
        return features + self.reduce(functional.gelu(self.expand(mixed)))


class Planes(nn.Module):
    """See the file's text.

    Args:
        classes: How many.
        shape: Cells along (radius, azimuth, height).
        widths: Channels of the planar blocks; rows halve in the stem and from block to block.
        circle: Channels along the circle.
        circle_blocks: Circular blocks.
        kernel: Their reach, in azimuth cells.
        hidden: Width of the last layer but one.
        dropout: Before each of the two last layers.
        channels: Of a grid: 2 for occupied and free cells.
        context: Numbers beside each grid, see `grid_context`; 0 for none.

    Raises:
        InputError: Cells that do not divide.
    """

    summaries: ClassVar[int] = 2
    """Vectors over the circle that the last layers see."""

    def __init__(
        self,
        classes: int,
        shape: tuple[int, int, int] = (32, 32, 32),
        widths: tuple[int, ...] = (32, 64, 128),
        circle: int = 256,
        circle_blocks: int = 2,
        kernel: int = 9,
        hidden: int = 256,
        dropout: float = 0.4,
        channels: int = 1,
        context: int = 0,
    ) -> None:
        super().__init__()
        radii, azimuths, heights = shape
        rows = 2 ** len(widths)
        if radii % rows or heights % rows or azimuths <= kernel // 2:
            raise InputError(
                f"planes needs radii and heights in multiples of {rows} and more than "
                f"{kernel // 2} azimuths, not {shape}"
            )
        self.panorama = PlaneBranch(channels * radii, heights, widths)
        self.plan = PlaneBranch(channels * heights, radii, widths)
        joined = self.panorama.features + self.plan.features
        self.join = nn.Sequential(
            nn.Conv1d(joined, circle, 1, bias=False), nn.BatchNorm1d(circle), nn.ReLU()
        )
        self.circle = nn.Sequential(
            *(CircleBlock(circle, kernel) for _ in range(circle_blocks)), nn.BatchNorm1d(circle)
        )
        self.pool = RowWisePool()
        self.context = context_layers(context) if context else None
        beside = CONTEXT_FEATURES if context else 0
        self.head = class_head(self.summaries * circle + beside, hidden, classes, dropout)

    def forward(self, grids: Tensor, context: Tensor | None = None) -> Tensor:
        """Logits.

        Args:
            grids: (n, channels, radius, azimuth, height), 1 where occupied, and where free.
            context: (n, context) for a network that takes one.

        Returns:
            (n, classes).
        """
        pooled = self.pool(self.columns(grids))
        if self.context is not None:
            pooled = torch.cat([pooled, self.context(context)], 1)
        return self.head(pooled)

    def columns(self, grids: Tensor) -> Tensor:
        """What is known of each azimuth, (n, circle, azimuth); it turns with the object."""
        radii, azimuths, heights = grids.shape[2:]
        by_radius = grids.flatten(1, 2)
        # In two steps, which ONNX Runtime copies in rows; (0, 1, 4, 3, 2) it copies cell by cell.
        rows = grids.transpose(2, 3).reshape(-1, grids.shape[1], azimuths * radii, heights)
        by_height = rows.transpose(2, 3).reshape(-1, grids.shape[1] * heights, azimuths, radii)
        joined = self._projected(self.panorama(by_radius), self.plan(by_height))
        return self.circle(self.join[1:](joined))

    def _projected(self, *branches: Tensor) -> Tensor:
        """All channels and rows of an azimuth to `circle` features, without copying them first."""
        projection = self.join[0]
        assert isinstance(projection, nn.Conv1d)
        sizes = [found.shape[1] * found.shape[3] for found in branches]
        parts = []
        for found, weight in zip(branches, torch.split(projection.weight, sizes, 1), strict=True):
            kernel = weight.reshape(len(weight), found.shape[1], 1, found.shape[3])
            parts.append(functional.conv2d(found, kernel).squeeze(3))
        return parts[0] + parts[1]


def context_layers(context: int) -> nn.Sequential:
    """Numbers beside a grid as features."""
    return nn.Sequential(
        nn.Linear(context, CONTEXT_FEATURES), nn.ReLU(),
        nn.Linear(CONTEXT_FEATURES, CONTEXT_FEATURES), nn.ReLU(),
    )  # fmt: skip


def class_head(inputs: int, hidden: int, classes: int, dropout: float) -> nn.Sequential:
    """The last two layers."""
    return nn.Sequential(
        nn.Dropout(dropout),
        nn.Linear(inputs, hidden),
        nn.BatchNorm1d(hidden),
        nn.ReLU(),
        nn.Dropout(dropout),
        nn.Linear(hidden, classes),
    )
