"""Rendering of points to images, as the first layer of a network."""

from __future__ import annotations

import math

import torch
from torch import Tensor

BEYOND = 1.05
"""Smallest nearness, which separates the farthest points from the background."""


def nearest_of_each(cells: Tensor, values: Tensor, count: int) -> Tensor:
    """Maximum of the values in each cell, 0 for empty cells.

    Args:
        cells: (n, m) int64 in 0 … count - 1.
        values: (n, m), not negative.
        count: Number of cells.

    Returns:
        (n, count).
    """
    empty = values.new_zeros((values.shape[0], count))
    return empty.scatter_reduce(1, cells, values, "amax")


def panorama(points: Tensor, azimuths: int, heights: int) -> Tensor:
    """Panorama of the surface's radius on the unrolled cylinder around an object.

    Args:
        points: (n, m, 3) relative to the axis, in a cylinder of radius 1 and half height 1.
        azimuths: Number of columns.
        heights: Number of rows.

    Returns:
        (n, 1, azimuths, heights), 0 where empty.
    """
    x, y, z = points.unbind(-1)
    column = _cell((torch.atan2(y, x) / math.tau) % 1.0, azimuths)
    row = _cell((z + 1) / 2, heights)
    out = torch.sqrt(x * x + y * y)
    image = nearest_of_each(column * heights + row, out, azimuths * heights)
    return image.view(-1, 1, azimuths, heights)


def depth_images(points: Tensor, views: int, size: int, elevation: float) -> Tensor:
    """Orthographic depth images from a circle of cameras that face the centre.

    Args:
        points: (n, m, 3) relative to the centre. The images extend slightly beyond the farthest
            point, so that objects fill them as in the paper.
        views: Number of cameras, evenly spaced in azimuth.
        size: Side of the images [px].
        elevation: Elevation of the cameras [rad].

    Returns:
        (n, views, size, size) nearness, from 0 where empty to 1 at the camera.
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
    # No matrix product, because mixed precision would move points to other pixels.
    x, y, z = (points / reach[:, None, None]).unsqueeze(-1).unbind(2)
    u, v, near = (x * a[:, 0] + y * a[:, 1] + z * a[:, 2] for a in (right, up, towards))
    pixel = _cell((v + 1) / 2, size) * size + _cell((u + 1) / 2, size)
    flat = pixel.transpose(1, 2).reshape(-1, points.shape[1])
    nearness = ((near + 1) / 2).clamp(0, 1).transpose(1, 2).reshape(-1, points.shape[1])
    return nearest_of_each(flat, nearness, size * size).view(-1, views, size, size)


def _cell(share: Tensor, count: int) -> Tensor:
    return (share * count).long().clamp(0, count - 1)
