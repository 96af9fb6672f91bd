import torch

from circumspect.classification import GridSpec
from circumspect.nets import build_net
from circumspect.nets.committee import Committee

INPUT_SPEC = GridSpec()


def test_the_answer_is_the_mean_of_the_members():
    net = Committee(build_net("planes", 4, INPUT_SPEC) for _ in range(2)).eval()
    grids = (
        torch.rand(3, 1, *INPUT_SPEC.shape, generator=torch.Generator().manual_seed(0)) < 0.1
    ).float()
    with torch.no_grad():
        apart = torch.stack([member(grids) for member in net.members])
        torch.testing.assert_close(net(grids), apart.mean(0))
        assert not torch.allclose(apart[0], apart[1])
