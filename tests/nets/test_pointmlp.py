"""PointMLP against the formulas of its paper, and its invariances."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from network_inputs import trained_looking

from circumspect.classification import PointsSpec
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.nets import NETS, build_net
from circumspect.nets.pointmlp import NEIGHBOURS, PointMLP, PointMlpStage, chosen, nearest, spread

SEEDS = st.integers(0, 2**20)


def drawn(seed, *shape):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def shuffled(points, bounds, seed=0):
    """The points between each two bounds in another order."""
    chance = torch.Generator().manual_seed(seed)
    parts = [
        start + torch.randperm(end - start, generator=chance)
        for start, end in itertools.pairwise(bounds)
    ]
    return points[:, torch.cat(parts)]


def test_the_number_of_weights_is_that_of_the_paper():
    # 0.68 M for 40 classes: the paper counts in units of 2^20, as 12.6 M of the large form show.
    weights = sum(p.numel() for p in PointMLP(40).parameters())
    assert weights / 2**20 == pytest.approx(0.68, abs=0.005)


@settings(max_examples=10)
@given(SEEDS, st.integers(2 * NEIGHBOURS, 80))
def test_neighbours_are_the_nearest_points_and_the_anchor_is_one(seed, count):
    points = drawn(seed, 2, count, 3)
    near = nearest(points, count // 2)
    assert near.shape == (2, count // 2, NEIGHBOURS)
    for cloud, rows in zip(points.double(), near, strict=True):
        away = torch.cdist(cloud[: count // 2], cloud)
        expected = away.sort(dim=1).values[:, :NEIGHBOURS]
        found = away.gather(1, rows).sort(dim=1).values
        torch.testing.assert_close(found, expected, atol=1e-4, rtol=0)
        assert all(anchor in row for anchor, row in enumerate(rows.tolist()))


def test_mixed_precision_chooses_the_same_neighbours():
    points = drawn(3, 2, 100, 3)
    with torch.autocast("cpu", torch.bfloat16):
        mixed = nearest(points, 50)
    assert torch.equal(mixed, nearest(points, 50))


@settings(max_examples=10)
@given(SEEDS)
def test_the_first_layer_is_that_of_the_paper(seed):
    """It is applied to points, the paper's to the neighbours of each anchor one by one."""
    torch.manual_seed(seed)
    stage, points, features = (
        PointMlpStage(4, 8, 1).double(),
        drawn(seed, 2, 60, 3),
        drawn(seed, 2, 60, 4),
    )
    features = features.double()
    with torch.no_grad():
        stage.alpha.normal_()
        stage.beta.normal_()
        near = nearest(points, 30)
        found = stage.first_layer(features, near)
    weights = torch.cat([stage.of_neighbour.weight, stage.of_anchor.weight], 1)
    for cloud in range(2):
        beside = torch.stack(
            [
                torch.stack([features[cloud, j] - features[cloud, i] for j in near[cloud, i]])
                for i in range(30)
            ]
        )
        sigma = math.sqrt(float(beside.square().sum()) / beside.numel())
        torch.testing.assert_close(float(spread(features, near)[cloud]), sigma)
        affine = stage.alpha * beside / sigma + stage.beta
        anchors = features[cloud, :30, None].expand(-1, NEIGHBOURS, -1)
        torch.testing.assert_close(found[cloud], torch.cat([affine, anchors], 2) @ weights.T)


def test_chosen_features_are_those_of_the_points_that_are_named():
    features = drawn(0, 3, 7, 2)
    near = torch.randint(7, (3, 4, 5), generator=torch.Generator().manual_seed(0))
    found = chosen(features, near)
    for cloud in range(3):
        assert torch.equal(found[cloud], features[cloud][near[cloud]])


def test_logits_of_any_number_of_points():
    net = trained_looking("pointmlp")
    for count in (8 * NEIGHBOURS, 512, 1024):
        assert net(drawn(1, 2, count, 3)).shape == (2, 3)


def test_the_size_is_that_of_the_paper():
    """PointMLP-elite: 0.68 M weights for forty classes."""
    net = build_net("pointmlp", 40, NETS["pointmlp"].input_spec)
    assert 0.65e6 < sum(weight.numel() for weight in net.parameters()) < 0.75e6


def test_the_order_of_points_within_a_sample_does_not_matter():
    net, points = trained_looking("pointmlp"), drawn(2, 2, 1024, 3)
    with torch.no_grad():
        expected = net(points)
        same_samples = shuffled(points, (0, 64, 128, 256, 512, 1024))
        torch.testing.assert_close(net(same_samples), expected, atol=1e-4, rtol=1e-4)
        others = shuffled(points, (0, 1024))
        assert (net(others) - expected).abs().max() > 1e-3


def test_an_answer_depends_on_no_other_object_of_the_batch():
    net, points = trained_looking("pointmlp"), drawn(4, 3, 512, 3)
    with torch.no_grad():
        alone = torch.cat([net(row[None]) for row in points])
        torch.testing.assert_close(net(points), alone, atol=1e-4, rtol=1e-4)


def test_the_order_in_which_a_camera_gave_the_points_does_not_matter():
    """The input specification makes the order, and begins with the outermost point."""
    net, input_spec = trained_looking("pointmlp"), PointsSpec(1024, farthest_first=True)
    points_xyz = make_furniture("chair", 1).sampled(1024, 0).points_xyz
    other = np.random.default_rng(0).permutation(points_xyz)
    inputs = [input_spec.inputs(PointCloud(given))[0] for given in (points_xyz, other)]
    with torch.no_grad():
        first, later = (net(torch.from_numpy(points)) for points in inputs)
    torch.testing.assert_close(first, later, atol=1e-3, rtol=1e-3)


@pytest.mark.parametrize("distinct", [1, 20])
def test_copies_of_a_few_points_give_finite_answers(distinct):
    """A small cloud is filled up with copies: all neighbours of a point may be the point itself."""
    net, few = trained_looking("pointmlp"), drawn(5, 2, distinct, 3)
    points = few.repeat(1, -(-256 // distinct), 1)[:, :256].requires_grad_()
    assert net(points).isfinite().all()
    if distinct > 1:
        net.train()(points).square().sum().backward()
        assert points.grad is not None
        assert points.grad.isfinite().all()
        assert all(p.grad.isfinite().all() for p in net.parameters() if p.grad is not None)
