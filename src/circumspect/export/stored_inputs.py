"""Networks that take inputs as they are stored, uint8."""

from __future__ import annotations

from torch import Tensor, nn

from circumspect.classification import GridRecipe, InputRecipe
from circumspect.nets.state_channels import state_channels


def taking_stored_inputs(net: nn.Module, recipe: InputRecipe) -> nn.Module:
    """The network, for evaluation, behind a layer that makes floats of what is stored.

    Args:
        net: Takes what the recipe makes, as float32.
        recipe: Of its inputs.
    """
    if recipe.takes_context:
        assert isinstance(recipe, GridRecipe)
        return _StatesAsStored(net, recipe.visibility).eval()
    return _AsStored(net).eval()


class _AsStored(nn.Module):
    """Takes grids as they are stored, uint8, and points as they are."""

    def __init__(self, net: nn.Module) -> None:
        super().__init__()
        self.net = net

    def forward(self, given: Tensor) -> Tensor:
        return self.net(given.float())


class _StatesAsStored(nn.Module):
    """Takes the states of cells as they are stored, uint8, and a context beside them."""

    def __init__(self, net: nn.Module, visibility: bool) -> None:
        super().__init__()
        self.net = net
        self.visibility = visibility

    def forward(self, given: Tensor, context: Tensor) -> Tensor:
        return self.net(state_channels(given) if self.visibility else given.float(), context)
