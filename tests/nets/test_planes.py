"""`planes`: the layers as they are computed against the layers as they are described."""

import pytest
import torch
from torch import nn

from circumspect.nets.planes import PlaneBranch, Planes, Shortcut


@pytest.mark.parametrize("stride", [1, 2, 4])
def test_a_shortcut_is_a_mean_and_a_projection(stride):
    torch.manual_seed(stride)
    shortcut = Shortcut(6, 10, stride).eval()
    features = torch.randn(3, 6, 8, 16)
    plainly = nn.Sequential(*shortcut).eval()
    torch.testing.assert_close(shortcut(features), plainly(features))


@pytest.mark.parametrize("shape", [(32, 32, 32), (16, 24, 32), (32, 12, 16)])
@pytest.mark.parametrize("channels", [1, 2])
def test_columns_are_those_of_vectors_along_the_azimuth(shape, channels):
    """Branches reduced to one vector an azimuth, joined by a convolution over them."""
    torch.manual_seed(0)
    net = Planes(5, shape, channels=channels, circle=24).eval()
    grids = (torch.rand(2, channels, *shape) < 0.2).float()

    def vectors(branch: PlaneBranch, planes: torch.Tensor) -> torch.Tensor:
        return branch(planes).permute(0, 1, 3, 2).flatten(1, 2)

    by_radius = grids.flatten(1, 2)
    by_height = grids.permute(0, 1, 4, 3, 2).flatten(1, 2)
    joined = torch.cat([vectors(net.panorama, by_radius), vectors(net.plan, by_height)], 1)
    assert joined.shape == (2, net.panorama.features + net.plan.features, shape[1])
    expected = net.circle(net.join(joined))
    torch.testing.assert_close(net.columns(grids), expected, rtol=1e-4, atol=1e-5)


def test_a_turn_by_whole_cells_turns_the_columns():
    torch.manual_seed(0)
    net = Planes(5, channels=2, circle=24).eval()
    grids = (torch.rand(1, 2, 32, 32, 32) < 0.1).float()
    turned = net.columns(grids.roll(5, dims=3))
    torch.testing.assert_close(turned, net.columns(grids).roll(5, dims=2), rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(net(grids), net(grids.roll(5, dims=3)), rtol=1e-4, atol=1e-5)
