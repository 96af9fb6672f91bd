"""The paper's network is that of its Table 1."""

import pytest
import torch

from circumspect.errors import InputError
from circumspect.nets import NETS
from circumspect.nets.moon2018 import Moon2018, RowWiseMaxPool
from circumspect.training.optimisation import MOMENTUM
from circumspect.training.settings import TrainingSettings


def sizes(net):
    return [
        sum(parameter.numel() for parameter in layer.parameters())
        for layer in net.layers
        if list(layer.parameters())
    ]


def test_table_1_to_the_parameter():
    net = Moon2018(10)
    assert sizes(net) == [448, 64_032, 55_360, 221_312, 63_439_872, 524_800, 5_130]
    assert sum(sizes(net)) == 64_310_954


def test_the_outputs_of_the_convolutions_are_those_of_table_1():
    features = torch.zeros(1, 1, 32, 32, 32)
    shapes = []
    for layer in Moon2018(10).eval().layers:
        if isinstance(layer, torch.nn.Flatten):
            break
        features = layer(features)
        if isinstance(layer, torch.nn.Conv3d | RowWiseMaxPool):
            shapes.append(tuple(features.shape[1:]))
    assert shapes == [
        (16, 30, 30, 30), (32, 26, 26, 26), (64, 24, 24, 24), (128, 22, 22, 22), (128, 22, 1, 22),
    ]  # fmt: skip


def test_row_wise_pooling_is_invariant_along_the_azimuth():
    features = torch.rand(2, 3, 4, 6, 5)
    pooled = RowWiseMaxPool()(features)
    assert pooled.shape == (2, 3, 4, 1, 5)
    torch.testing.assert_close(pooled, RowWiseMaxPool()(features.roll(2, 3)))
    torch.testing.assert_close(pooled[..., 0, :], features.max(3).values)


@pytest.mark.parametrize("pool", ["rwmp", "max"])
def test_without_wrapping_invariance_is_approximate(pool):
    torch.manual_seed(0)
    net = Moon2018(3, (14, 14, 14), pool).eval()
    grids = (torch.rand(2, 1, 14, 14, 14) < 0.1).float()
    with torch.no_grad():
        assert not torch.allclose(net(grids), net(grids.roll(5, 3)), atol=1e-4)


@pytest.mark.parametrize(("pool", "needed"), [("rwmp", 11), ("max", 12)])
def test_a_grid_of_too_few_cells_is_refused(pool, needed):
    features = torch.zeros(1, 1, needed, needed + 1, needed)
    assert Moon2018(3, tuple(features.shape[2:]), pool).eval()(features).shape == (1, 3)
    with pytest.raises(InputError, match=f"needs {needed} cells or more"):
        Moon2018(3, (32, needed - 1, 32), pool)


@pytest.mark.parametrize("name", ["moon2018", "moon2018-max"])
def test_departures_from_the_paper_match_the_settings(name):
    spec = NETS[name]
    done = TrainingSettings(**spec.training)
    for reported in (
        f"momentum of {MOMENTUM:g},", f" {done.epochs} epochs in batches of {done.batch_size},",
        f" rises to {done.learning_rate:g} ", f" length of {done.gradient_norm:g};",
    ):  # fmt: skip
        assert reported in spec.departures
    assert ("2x2x2" in spec.departures) == (name == "moon2018-max")
