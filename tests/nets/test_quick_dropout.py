"""Dropout with cheap random bits has the properties of dropout."""

import pytest
import torch

from circumspect.nets.moon2018 import QuickDropout


@pytest.mark.parametrize("p", [0.1, 0.4, 0.9])
@pytest.mark.parametrize("layout", [torch.contiguous_format, torch.channels_last_3d])
@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16])
def test_values_are_zero_or_scaled_with_the_probability(p, layout, dtype) -> None:
    torch.manual_seed(0)
    features = torch.rand(4, 8, 15, 16, 17).add(1).to(dtype).to(memory_format=layout)
    dropped = QuickDropout(p)(features)
    assert dropped.dtype == dtype
    assert dropped.is_contiguous(memory_format=layout)
    kept = dropped != 0
    # Five standard deviations of 130,560 random bits.
    assert float(kept.float().mean()) == pytest.approx(1 - p, abs=5 * 0.5 / 130_560**0.5)
    scaled = features * torch.tensor(1 / (1 - p), dtype=dtype)
    torch.testing.assert_close(dropped[kept], scaled[kept])


def test_neighbours_are_dropped_independently() -> None:
    torch.manual_seed(1)
    kept = (QuickDropout(0.5)(torch.ones(200_000)) != 0).float() - 0.5
    for lag in range(1, 9):
        assert abs(float((kept[lag:] * kept[:-lag]).mean())) < 5 * 0.25 / 200_000**0.5


def test_gradients_pass_where_values_passed() -> None:
    features = torch.randn(3, 5, 7, requires_grad=True)
    dropped = QuickDropout(0.4)(features)
    dropped.sum().backward()
    torch.testing.assert_close(features.grad * features.detach(), dropped.detach())


def test_the_seed_repeats_the_sequence_of_different_masks() -> None:
    dropout, ones = QuickDropout(0.4), torch.ones(1000)
    torch.manual_seed(7)
    first, second = dropout(ones), dropout(ones)
    torch.manual_seed(7)
    assert torch.equal(dropout(ones), first)
    assert not torch.equal(first, second)


@pytest.mark.parametrize("shape", [(0,), (1,), (5,)])
def test_any_number_of_values_is_dropped_from(shape) -> None:
    assert QuickDropout(0.4)(torch.ones(shape)).shape == shape
    assert not QuickDropout(1.0)(torch.ones(shape)).any()


def test_nothing_is_dropped_outside_of_training() -> None:
    features = torch.rand(50)
    assert torch.equal(QuickDropout(0.4).eval()(features), features)
    assert torch.equal(QuickDropout(0.0)(features), features)
