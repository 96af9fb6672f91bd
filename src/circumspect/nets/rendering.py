"""Images of points, as the first layer of a network."""

from __future__ import annotations

import math

import torch
from torch import Tensor


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
        points: (n, m, 3) about the axis, within a cylinder of radius 1 and half height 1.
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
    reach = math.sqrt(2.0)
    u, v, near = (points @ axis.T.to(points.dtype) / reach for axis in (right, up, towards))
    pixel = _cell((v + 1) / 2, size) * size + _cell((u + 1) / 2, size)
    flat = pixel.transpose(1, 2).reshape(-1, points.shape[1])
    nearness = ((near + 1) / 2).clamp(0, 1).transpose(1, 2).reshape(-1, points.shape[1])
    return nearest_of_each(flat, nearness, size * size).view(-1, views, size, size)


def _cell(share: Tensor, count: int) -> Tensor:
    return (share * count).long().clamp(0, count - 1)
