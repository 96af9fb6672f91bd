"""Inputs and invariances of the rival networks."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from network_inputs import trained_looking

from circumspect.errors import InputError
from circumspect.nets.pointnet import PointNet, Transform
from circumspect.nets.rendering import BEYOND, depth_images, nearest_of_each, panorama
from circumspect.nets.voxelnet import AZIMUTHS, CELLS, HEIGHTS, RADII, in_cells
from circumspect.nets.voxnet import VoxNet


def turned(points, angle):
    cosine, sine = math.cos(angle), math.sin(angle)
    matrix = torch.tensor([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return points @ matrix


def points_within_cells(count, seed=0):
    """Away from the borders of the cells, where rounding decides."""
    rng = np.random.default_rng(seed)
    cells = [
        rng.integers(n, size=count) + rng.uniform(0.1, 0.9, count)
        for n in (RADII, AZIMUTHS, HEIGHTS)
    ]
    radius, angle, height = (
        cells[0] / RADII,
        cells[1] / AZIMUTHS * 2 * np.pi,
        2 * cells[2] / HEIGHTS - 1,
    )
    xyz = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], -1)
    return torch.from_numpy(xyz.astype(np.float32))[None]


@given(seed=st.integers(0, 2**20), count=st.integers(1, 60))
def test_the_largest_of_each_cell(seed, count):
    rng = np.random.default_rng(seed)
    cells, values = rng.integers(7, size=(2, count)), rng.random((2, count))
    found = nearest_of_each(torch.from_numpy(cells), torch.from_numpy(values), 7).numpy()
    for row in range(2):
        for cell in range(7):
            there = values[row][cells[row] == cell]
            assert found[row, cell] == (there.max() if len(there) else 0)


def test_a_panorama_shows_how_far_out_the_surface_reaches():
    points = torch.tensor([[[0.5, 0.1, 0.0], [0.3, 0.06, 0.0], [-0.2, 0.0, -0.99]]])
    image = panorama(points, 8, 4)
    assert image.shape == (1, 1, 8, 4)
    assert image[0, 0, 0, 2] == pytest.approx(math.hypot(0.5, 0.1))
    assert image[0, 0, 4, 0] == pytest.approx(0.2)
    assert (image > 0).sum() == 2


def test_a_turn_by_whole_columns_rolls_the_panorama():
    points = points_within_cells(300)
    image, later = panorama(points, 32, 16), panorama(turned(points, 3 * math.tau / 32), 32, 16)
    torch.testing.assert_close(later, image.roll(3, 2))


def test_depth_images_look_from_all_around_at_the_near_side():
    points = torch.tensor([[[0.9, 0.0, 0.0], [-0.9, 0.0, 0.0]]])
    images = depth_images(points, 4, 16, 0.0)
    assert images.shape == (1, 4, 16, 16)
    # From +x both points lie in the middle, and the one at +x is nearer.
    near = (1 / BEYOND + 1) / 2
    assert images[0, 0].max() == pytest.approx(near, abs=1e-5)
    assert (images[0, 0] > 0).sum() == 1
    assert (images[0, 1] > 0).sum() == 2
    torch.testing.assert_close(images[0, 0].flip(1).max(), images[0, 2].max())
    # However large the object is.
    torch.testing.assert_close(depth_images(0.1 * points, 4, 16, 0.0), images)


def test_up_is_up_in_depth_images():
    points = torch.tensor([[[0.0, 0.0, 0.8]]])
    rows = (depth_images(points, 6, 16, math.radians(30))[0] > 0).nonzero()[:, 1]
    assert (rows > 8).all()


def test_adding_points_never_reduces_an_image():
    points = points_within_cells(200)
    points = points[:, points[0].norm(dim=1).argsort(descending=True)]
    some, all_of_it = (depth_images(p, 12, 32, 0.5) for p in (points[:, :100], points))
    assert (all_of_it >= some).all()


def test_cells_are_those_of_the_grid():
    points = points_within_cells(500)
    features, cells = in_cells(points)
    x, y, z = points[0].double().numpy().T
    expected = (
        np.floor(np.hypot(x, y) * RADII) * AZIMUTHS
        + np.floor(np.mod(np.arctan2(y, x), 2 * np.pi) / (2 * np.pi) * AZIMUTHS)
    ) * HEIGHTS + np.floor((z + 1) / 2 * HEIGHTS)
    np.testing.assert_array_equal(cells[0].numpy(), expected)
    assert features.shape == (1, 500, 5)
    assert features[..., 2:].abs().max() <= 0.5
    outside = in_cells(torch.tensor([[[3.0, 0.0, 3.0], [0.0, 0.0, -3.0]]]))[1]
    assert outside.min() >= 0
    assert outside.max() < CELLS


def test_voxelnet_is_invariant_to_whole_cells():
    net, points = trained_looking("voxelnet"), points_within_cells(2000)
    with torch.no_grad():
        first, later = net(points), net(turned(points, 5 * math.tau / AZIMUTHS))
        other = net(turned(points, 5.5 * math.tau / AZIMUTHS))
    torch.testing.assert_close(first, later, atol=1e-3, rtol=1e-3)
    assert not torch.allclose(first, other, atol=1e-3)


def test_views_all_around_are_invariant_to_rotations_by_one_view():
    net, points = trained_looking("mvcnn"), points_within_cells(3000)
    with torch.no_grad():
        first, later = net(points), net(turned(points, math.tau / 12))
        other = net(turned(points, math.tau / 24))
    assert (first - later).abs().max() < 0.2 * (first - other).abs().max()


def test_the_order_of_points_does_not_matter():
    net, points = trained_looking("pointnet"), points_within_cells(1024)
    with torch.no_grad():
        shuffled = points[:, torch.randperm(1024, generator=torch.Generator().manual_seed(0))]
        torch.testing.assert_close(net(points), net(shuffled), atol=1e-4, rtol=1e-4)


def test_a_fresh_transform_leaves_points_as_they_are():
    transform = Transform(3).eval()
    points = torch.rand(2, 50, 3)
    torch.testing.assert_close(transform(points), points)
    assert sum(p.numel() for p in PointNet(40).parameters()) == pytest.approx(3.5e6, rel=0.02)


def test_voxnet_has_the_published_size():
    # Maturana and Scherer give 921,736 weights for their grid of 32 cells and 40 classes.
    assert sum(p.numel() for p in VoxNet(40).parameters()) == 921_736
    with pytest.raises(InputError, match="11 cells"):
        VoxNet(10, (8, 8, 8))
