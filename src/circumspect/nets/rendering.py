"""Images of points, as the first layer of a network."""

from __future__ import annotations

import math

import torch
from torch import Tensor

BEYOND = 1.05
"""What is farthest from a camera is told from nothing by this."""


def nearest_of_each(cells: Tensor, values: Tensor, count: int) -> Tensor:
    """The largest value that falls into each cell, 0 where none does.

    Args:
        cells: (n, m) int64 in 0 … count - 1.
        values: (n, m) not negative.
        count: How many cells.

    Returns:
        (n, count).
    """
    empty = values.new_zeros((values.shape[0], count))
    return empty.scatter_reduce(1, cells, values, "amax")


def panorama(points: Tensor, azimuths: int, heights: int) -> Tensor:
    """The cylinder round an object, unrolled: how far out the surface reaches.

    Args:
        points: (n, m, 3) about the axis, within a cylinder of radius 1 and half height 1.
        azimuths: Columns.
        heights: Rows.

    Returns:
        (n, 1, azimuths, heights), 0 where there is nothing.
    """
    x, y, z = points.unbind(-1)
    column = _cell((torch.atan2(y, x) / math.tau) % 1.0, azimuths)
    row = _cell((z + 1) / 2, heights)
    out = torch.sqrt(x * x + y * y)
    image = nearest_of_each(column * heights + row, out, azimuths * heights)
    return image.view(-1, 1, azimuths, heights)


def depth_images(points: Tensor, views: int, size: int, elevation: float) -> Tensor:
    """Orthographic depth images from a circle of cameras that look at the middle.

    Args:
        points: (n, m, 3) about the middle; the pictures reach a little beyond the farthest one,
            so that objects fill them as they do in the paper.
        views: Cameras, evenly over the azimuth.
        size: Pixels along each side.
        elevation: [rad] of the cameras.

    Returns:
        (n, views, size, size): nearness, 0 where there is nothing up to 1 at the camera.
    """
    angles = torch.arange(views, device=points.device) * (math.tau / views)
    towards = torch.stack(
        [
            math.cos(elevation) * torch.cos(angles),
            math.cos(elevation) * torch.sin(angles),
            torch.full_like(angles, math.sin(elevation)),
        ],
        -1,
    )
    right = torch.stack([-torch.sin(angles), torch.cos(angles), torch.zeros_like(angles)], -1)
    up = torch.linalg.cross(towards, right)
    reach = BEYOND * points.square().sum(-1).amax(1).sqrt().clamp(min=1e-6)
    # Not a matrix product: mixed precision would move points to other pixels.
    x, y, z = (points / reach[:, None, None]).unsqueeze(-1).unbind(2)
    u, v, near = (x * a[:, 0] + y * a[:, 1] + z * a[:, 2] for a in (right, up, towards))
    pixel = _cell((v + 1) / 2, size) * size + _cell((u + 1) / 2, size)
    flat = pixel.transpose(1, 2).reshape(-1, points.shape[1])
    nearness = ((near + 1) / 2).clamp(0, 1).transpose(1, 2).reshape(-1, points.shape[1])
    return nearest_of_each(flat, nearness, size * size).view(-1, views, size, size)


def _cell(share: Tensor, count: int) -> Tensor:
    return (share * count).long().clamp(0, count - 1)
