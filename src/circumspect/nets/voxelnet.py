"""VoxelNet's feature encoding on a cylindrical grid: Y. Zhou, O. Tuzel, "VoxelNet: End-to-End
Learning for Point Cloud Based 3D Object Detection", CVPR 2018.
"""

from __future__ import annotations

import itertools
import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.nets.azimuth import RowWisePool, wrap
from circumspect.nets.pointnet import Shared

RADII, AZIMUTHS, HEIGHTS = 16, 32, 16
CELLS = RADII * AZIMUTHS * HEIGHTS
ENCODED = 32
WIDTHS = (48, 96)
COLUMN = 256


class FeatureEncoding(nn.Module):
    """Voxel feature encoding: features of each point, concatenated with the maxima of its cell.

    Args:
        inputs: Input features of a point.
        outputs: Output features, twice the number of learnt ones.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.each = Shared(inputs, outputs // 2)

    def forward(self, features: Tensor, cells: Tensor) -> Tensor:
        """Map (n, m, inputs) features and (n, m) cells to (n, m, outputs)."""
        learnt = self.each(features)
        index = cells.unsqueeze(2).expand(-1, -1, learnt.shape[2])
        return torch.cat([learnt, _max_per_cell(learnt, index).gather(1, index)], 2)


class VoxelNet(nn.Module):
    """Voxel feature encoding on a cylindrical grid, followed by wrapped convolutions.

    Args:
        classes: Number of classes.
    """

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.encoding = nn.ModuleList([FeatureEncoding(5, 16), FeatureEncoding(16, ENCODED)])
        self.last = Shared(ENCODED, ENCODED)
        widths = (ENCODED, *WIDTHS)
        self.convolutions = nn.ModuleList(
            nn.Conv3d(i, o, 3, stride=(2, 1, 2), padding=(1, 0, 1), bias=False)
            for i, o in itertools.pairwise(widths)
        )
        self.norms = nn.ModuleList(nn.BatchNorm3d(o) for o in WIDTHS)
        shrink = 4 ** len(WIDTHS)
        self.column = nn.Sequential(
            nn.Conv1d(WIDTHS[-1] * RADII * HEIGHTS // shrink, COLUMN, 1, bias=False),
            nn.BatchNorm1d(COLUMN),
            nn.ReLU(),
        )
        self.pool = RowWisePool()
        self.head = nn.Sequential(nn.Dropout(0.4), nn.Linear(2 * COLUMN, classes))

    def forward(self, points: Tensor) -> Tensor:
        """Logits.

        Args:
            points: (n, m, 3) about the axis.

        Returns:
            (n, classes).
        """
        features, cells = in_cells(points)
        for encoding in self.encoding:
            features = encoding(features, cells)
        features = self.last(features)
        index = cells.unsqueeze(2).expand(-1, -1, ENCODED)
        grid = _max_per_cell(features, index).transpose(1, 2)
        grid = grid.reshape(-1, ENCODED, RADII, AZIMUTHS, HEIGHTS)
        for convolution, norm in zip(self.convolutions, self.norms, strict=True):
            grid = functional.relu(norm(convolution(wrap(grid, 1, 3))))
        columns = grid.permute(0, 1, 2, 4, 3).flatten(1, 3)
        return self.head(self.pool(self.column(columns)))


def in_cells(points: Tensor) -> tuple[Tensor, Tensor]:
    """Features of the points, and their cells.

    Args:
        points: (n, m, 3) relative to the axis, in a cylinder of radius 1 and half height 1.

    Returns:
        (n, m, 5) radius, height, and offset from the cell's centre along radius, azimuth and
        height, each within ± 1/2; (n, m) int64 index of the cell.
    """
    x, y, z = points.unbind(-1)
    radius = torch.sqrt(x * x + y * y)
    along = torch.stack(
        [radius * RADII, (torch.atan2(y, x) / math.tau) % 1.0 * AZIMUTHS, (z + 1) / 2 * HEIGHTS], -1
    )
    most = torch.tensor([RADII, AZIMUTHS, HEIGHTS], device=points.device) - 1
    whole = torch.minimum(along.long().clamp(min=0), most)
    within = (along - whole - 0.5).clamp(-0.5, 0.5)
    cells = (whole[..., 0] * AZIMUTHS + whole[..., 1]) * HEIGHTS + whole[..., 2]
    return torch.cat([radius.unsqueeze(-1), z.unsqueeze(-1), within], -1), cells


def _max_per_cell(features: Tensor, index: Tensor) -> Tensor:
    """(n, CELLS, c) maximum of each feature in each cell; features are not negative."""
    empty = features.new_zeros((features.shape[0], CELLS, features.shape[2]))
    return empty.scatter_reduce(1, index, features, "amax")
