"""Inputs of networks, and networks that are away from their trivial start."""

import torch

from circumspect.classification import GridRecipe, PointsRecipe
from circumspect.nets import NETS, build_net


def small_recipe(name):
    """What a network is meant to be shown; less of it where millions of weights hang on it."""
    if name.startswith("moon2018"):
        return GridRecipe(shape=(14, 14, 14))
    return NETS[name].recipe


def some_inputs(recipe, count, seed=0):
    """(count, *input_shape): grids that are a tenth full, or points within the cylinder."""
    chance = torch.Generator().manual_seed(seed)
    drawn = torch.rand(count, *recipe.input_shape, generator=chance)
    if isinstance(recipe, PointsRecipe):
        return (drawn - 0.5) * 1.3
    return (drawn < 0.1).float()


def trained_looking(name, recipe=None, classes=3, seed=0):
    """A network whose batch norms and last layers are away from their trivial start."""
    torch.manual_seed(seed)
    recipe = recipe or small_recipe(name)
    net = build_net(name, classes, recipe)
    with torch.no_grad():
        for parameter in net.parameters():
            parameter.add_(0.05 * torch.randn_like(parameter))
        net.train()
        net(some_inputs(recipe, 8, seed))
    return net.eval()
