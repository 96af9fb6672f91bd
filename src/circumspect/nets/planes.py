"""The network of this project, which treats the cylinder as two stacks of planes.

One branch processes the (azimuth, height) panorama with all radii as channels, the other the
(azimuth, radius) plan with all heights as channels. Planar convolutions cost a fraction of spatial
ones, and strides reduce only height and radius. Each azimuth then becomes one feature vector.
Circular convolutions relate front, sides and back before row-wise pooling.

Predicting the orientation in addition to the class improves the class (ORION, Sedaghat et al.
2017). Here the orientation is a distribution over the azimuth cells. It rotates with the object,
and so do the columns that it weights. Their weighted sum is concatenated with the pooled features,
so that the result stays invariant.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.errors import InputError
from circumspect.nets.azimuth import RowWisePool, wrap

CONTEXT_FEATURES = 48
"""Number of features of the context."""


class Headed(NamedTuple):
    """Outputs in training.

    Attributes:
        logits: (n, classes).
        heading: (n, azimuth) logits of the cell that contains the object's 0°.
    """

    logits: Tensor
    heading: Tensor


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
        """Apply the convolution and the batch norm."""
        return self.norm(self.convolution(wrap(features, self.margin, dim=2)))


class Shortcut(nn.Sequential):
    """Mean over neighbouring rows, 1 × 1 convolution and batch norm in one step."""

    def __init__(self, inputs: int, outputs: int, row_stride: int) -> None:
        super().__init__(
            nn.AvgPool2d((1, row_stride)),
            nn.Conv2d(inputs, outputs, 1, bias=False),
            nn.BatchNorm2d(outputs),
        )
        self.row_stride = row_stride

    def forward(self, input: Tensor) -> Tensor:
        """Reduce the rows and change the channels."""
        _, projection, norm = self
        assert isinstance(projection, nn.Conv2d)
        weight = projection.weight.expand(-1, -1, -1, self.row_stride) / self.row_stride
        return norm(functional.conv2d(input, weight, stride=(1, self.row_stride)))


class PlaneBlock(nn.Module):
    """A residual block of two convolutions."""

    def __init__(self, inputs: int, outputs: int, row_stride: int) -> None:
        super().__init__()
        self.first = PlaneConvolution(inputs, outputs, row_stride=row_stride)
        self.second = PlaneConvolution(outputs, outputs)
        self.shortcut = nn.Identity()
        if inputs != outputs or row_stride != 1:
            self.shortcut = Shortcut(inputs, outputs, row_stride)

    def forward(self, features: Tensor) -> Tensor:
        """Add the convolutions to the shortcut."""
        inner = self.second(functional.relu(self.first(features)))
        return functional.relu(self.shortcut(features) + inner)


class PlaneBranch(nn.Module):
    """Residual blocks that map (n, channels, azimuth, rows) to more channels and fewer rows.

    Attributes:
        features: Number of output features per azimuth: channels times rows.
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
        """Apply the blocks."""
        return self.blocks(functional.relu(self.stem(planes)))


class CircleBlock(nn.Module):
    """Depthwise circular convolution over (n, c, azimuth), then a small network per cell."""

    def __init__(self, channels: int, kernel: int) -> None:
        super().__init__()
        self.margin = kernel // 2
        self.along = nn.Conv1d(channels, channels, kernel, groups=channels, bias=False)
        self.norm = nn.BatchNorm1d(channels)
        self.expand = nn.Conv1d(channels, 2 * channels, 1)
        self.reduce = nn.Conv1d(2 * channels, channels, 1)
        # The block is initialised as the identity.
        for parameter in self.reduce.parameters():
            nn.init.zeros_(parameter)

    def forward(self, features: Tensor) -> Tensor:
        """Apply the block."""
        mixed = self.norm(self.along(wrap(features, self.margin, dim=2)))
        return features + self.reduce(functional.gelu(self.expand(mixed)))


class Planes(nn.Module):
    """The network; see the module's docstring.

    Args:
        classes: Number of classes.
        shape: Cells along (radius, azimuth, height).
        widths: Channels of the planar blocks; rows halve in the stem and from block to block.
        circle: Channels of the circular blocks.
        circle_blocks: Number of circular blocks.
        kernel: Kernel of the circular convolutions [azimuth cells].
        hidden: Width of the hidden layer.
        dropout: Dropout before each of the last two layers.
        channels: Channels of a grid; 2 for occupied and free cells.
        context: Width of the context, see `grid_context`; 0 for none.

    Raises:
        InputError: The numbers of cells are not divisible as required.
    """

    summaries: ClassVar[int] = 2
    """Number of pooled vectors in the input of the last layers."""

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
            grids: (n, channels, radius, azimuth, height), 1 for occupied, and for free cells.
            context: (n, context); None for a network without context.

        Returns:
            (n, classes).
        """
        pooled = self.pool(self.columns(grids))
        if self.context is not None:
            pooled = torch.cat([pooled, self.context(context)], 1)
        return self.head(pooled)

    def columns(self, grids: Tensor) -> Tensor:
        """Features of each azimuth, (n, circle, azimuth); they rotate with the object."""
        radii, azimuths, heights = grids.shape[2:]
        by_radius = grids.flatten(1, 2)
        # In two steps, which ONNX Runtime copies in rows; it copies (0, 1, 4, 3, 2) by cell.
        rows = grids.transpose(2, 3).reshape(-1, grids.shape[1], azimuths * radii, heights)
        by_height = rows.transpose(2, 3).reshape(-1, grids.shape[1] * heights, azimuths, radii)
        joined = self._projected(self.panorama(by_radius), self.plan(by_height))
        return self.circle(self.join[1:](joined))

    def _projected(self, *branches: Tensor) -> Tensor:
        """Map all channels and rows of an azimuth to `circle` features, without a copy."""
        projection = self.join[0]
        assert isinstance(projection, nn.Conv1d)
        sizes = [found.shape[1] * found.shape[3] for found in branches]
        parts = []
        for found, weight in zip(branches, torch.split(projection.weight, sizes, 1), strict=True):
            kernel = weight.reshape(len(weight), found.shape[1], 1, found.shape[3])
            parts.append(functional.conv2d(found, kernel).squeeze(3))
        return parts[0] + parts[1]


def context_layers(context: int) -> nn.Sequential:
    """Layers that map the context to features."""
    return nn.Sequential(
        nn.Linear(context, CONTEXT_FEATURES), nn.ReLU(),
        nn.Linear(CONTEXT_FEATURES, CONTEXT_FEATURES), nn.ReLU(),
    )  # fmt: skip


def class_head(inputs: int, hidden: int, classes: int, dropout: float) -> nn.Sequential:
    """The last two layers of the network."""
    return nn.Sequential(
        nn.Dropout(dropout),
        nn.Linear(inputs, hidden),
        nn.BatchNorm1d(hidden),
        nn.ReLU(),
        nn.Dropout(dropout),
        nn.Linear(hidden, classes),
    )


class HeadedPlanes(Planes):
    """The network with an orientation output; the arguments are those of `Planes`.

    With the defaults, a committee of three has less than 2 M parameters.
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
            context: Unused; this network has no context.

        Returns:
            (n, classes); in training `Headed`.
        """
        columns = self.columns(grids)
        heading = self.facing(columns).squeeze(1)
        front = (columns * heading.softmax(1).unsqueeze(1)).sum(2)
        logits = self.head(torch.cat([self.pool(columns), front], 1))
        return Headed(logits, heading) if self.training else logits
