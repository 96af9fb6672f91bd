"""A network of your own: two convolutions on the cylinder's rings, in about 40 lines.

circumspect train --net own_network:RINGNET --data ModelNet10
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from circumspect.classification import GridSpec
from circumspect.nets import NetSpec


class RingNet(nn.Module):
    """Layers of height are channels; convolutions are over radius and azimuth, which wraps."""

    def __init__(self, classes: int, shape: tuple[int, int, int]) -> None:
        super().__init__()
        layers = shape[2]
        self.first = nn.Conv2d(layers, 32, 3, padding=(1, 0))
        self.second = nn.Conv2d(32, 64, 3, padding=(1, 0))
        self.norms = nn.ModuleList([nn.BatchNorm2d(32), nn.BatchNorm2d(64)])
        self.head = nn.Linear(64 * shape[0], classes)

    def forward(self, grids: Tensor) -> Tensor:
        """Class scores (n, classes) of grids (n, 1, radius, azimuth, height)."""
        x = grids[:, 0].permute(0, 3, 1, 2)
        for conv, norm in zip((self.first, self.second), self.norms, strict=True):
            wrapped = functional.pad(x, (1, 1, 0, 0), mode="circular")
            x = torch.relu(norm(conv(wrapped)))
        # The largest over the azimuth does not know where the azimuth begins.
        return self.head(x.amax(dim=3).flatten(1))


RINGNET = NetSpec(
    name="ringnet",
    summary="two wrapped convolutions over radius and azimuth",
    build=RingNet,
    input_spec=GridSpec("cylindrical", (16, 32, 16), margin=1.1),
    source="examples/own_network",
    training={"epochs": 12, "mixing": 0.0, "label_smoothing": 0.0},
    whole_cells=True,
)
