"""Whether a file answers as its networks do."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
import torch
from torch import nn

from circumspect.classification import GridRecipe, InputRecipe, PointsRecipe
from circumspect.classification.context import WIDTH
from circumspect.errors import CircumspectError
from circumspect.export.features import LOGITS
from circumspect.export.shown import Shown
from circumspect.grid.occupancy_grid import FREE, OCCUPIED

TOLERANCE = 1e-4
"""Largest difference of the logits in floating point; see `Fidelity`."""
AGREEMENT = 0.985
"""Share of the labels that must stay the same in eight bits; see `Fidelity`."""


@dataclass(frozen=True)
class Fidelity:
    """How well a file answers as its networks do.

    Attributes:
        difference: The largest difference between their logits, as a share of the largest logit
            where that is above 1.
        agreement: Share of the grids asked about that get the same label.
    """

    difference: float
    agreement: float


def fidelity_of(net: nn.Module, path: Path, probe: Shown) -> Fidelity:
    """Compare a file with its network.

    Args:
        net: Takes inputs as they are stored.
        path: The ONNX file.
        probe: What both are asked about.
    """
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [taken.name for taken in session.get_inputs()]
    actual = np.asarray(session.run([LOGITS], dict(zip(names, probe.arrays, strict=True)))[0])
    with torch.no_grad():
        expected = net(*map(torch.from_numpy, probe.arrays)).numpy()
    same = actual.argmax(axis=1) == expected.argmax(axis=1)
    largest = max(1.0, float(np.abs(expected).max()))
    return Fidelity(float(np.abs(actual - expected).max()) / largest, float(same.mean()))


def require_faithful(path: Path, fidelity: Fidelity, eight_bits: bool) -> None:
    """In floating point the logits must be the same, in eight bits the labels.

    Raises:
        CircumspectError: They are not.
    """
    if not eight_bits and not fidelity.difference < TOLERANCE:
        raise CircumspectError(
            f"{path}: not kept, its answers differ from the networks' by {fidelity.difference:.2g}"
        )
    if eight_bits and not fidelity.agreement >= AGREEMENT:
        raise CircumspectError(
            f"{path}: not kept, in eight bits only {fidelity.agreement:.1%} of the grids keep "
            "their label"
        )


def random_inputs(recipe: InputRecipe) -> Shown:
    """Random grids of several densities, empty and full ones among them; or random points."""
    rng = np.random.default_rng(0)
    if isinstance(recipe, PointsRecipe):
        return Shown(rng.uniform(-0.7, 0.7, (6, *recipe.input_shape)).astype(np.float32))
    densities = np.array([0.0, 0.01, 0.03, 0.1, 0.3, 1.0])[:, None, None, None, None]
    occupied = (rng.random((6, *recipe.input_shape)) < densities).astype(np.uint8)
    if not recipe.takes_context:
        return Shown(occupied)
    free = rng.random(occupied.shape) < 0.3
    states = np.where(occupied, np.uint8(OCCUPIED), np.uint8(FREE) * free).astype(np.uint8)
    assert isinstance(recipe, GridRecipe)
    contexts = rng.uniform(-1.0, 1.0, (6, WIDTH)).astype(np.float32)
    return Shown(states if recipe.visibility else occupied, contexts)
