import torch
from torch import nn

from circumspect.nets import NETS, build_net, cost_of
from circumspect.nets.committee import Committee

SHAPE = (32, 32, 32)


def grids(count=3):
    return (torch.rand(count, 1, *SHAPE, generator=torch.Generator().manual_seed(0)) < 0.1).float()


def test_the_answer_is_the_mean_of_the_members():
    net = build_net("planes-pair", 4, SHAPE).eval()
    assert isinstance(net, Committee)
    with torch.no_grad():
        apart = torch.stack([member(grids()) for member in net.members])
        torch.testing.assert_close(net(grids()), apart.mean(0))
        assert not torch.allclose(apart[0], apart[1])


def test_in_training_members_answer_apart_and_learn_apart():
    torch.manual_seed(0)
    net = Committee(nn.Sequential(nn.Flatten(), nn.Linear(8, 3)) for _ in range(2)).train()
    answers = net(torch.rand(5, 1, 2, 2, 2))
    assert answers.shape == (5, 2, 3)
    answers[:, 0].square().sum().backward()
    first, second = net.members
    assert all(p.grad is not None and p.grad.abs().max() > 0 for p in first.parameters())
    assert all(p.grad is None or p.grad.abs().max() == 0 for p in second.parameters())


def test_the_pair_is_within_what_a_robot_can_afford():
    cost = cost_of(build_net("planes-pair", 10, SHAPE), SHAPE)
    assert cost.parameters <= 2_000_000
    assert cost.multiply_adds <= 200_000_000
    assert "planes-pair" in NETS
