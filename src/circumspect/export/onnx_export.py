"""Checkpoints as ONNX, kept only if the file answers as they do."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import torch
from torch import Tensor, nn

from circumspect.classification import GridRecipe, InputRecipe, PointsRecipe
from circumspect.classification.context import WIDTH
from circumspect.classification.model_description import FORMAT, OBJECTS, checked_temperature
from circumspect.datasets.training_objects import OTHER
from circumspect.errors import CircumspectError, InputError
from circumspect.export.description import describe
from circumspect.export.eight_bit import in_eight_bits, require_convolutions
from circumspect.export.features import LOGITS, add_features
from circumspect.export.shown import Shown
from circumspect.geometry.ignored_warnings import ignored_warnings
from circumspect.grid.occupancy_grid import FREE, OCCUPIED
from circumspect.nets import Checkpoint
from circumspect.nets.committee import Committee
from circumspect.nets.state_channels import state_channels
from circumspect.storage import atomic_path

OPSET = 18
TOLERANCE = 1e-4
"""Logits in floating point, see `Fidelity`."""
AGREEMENT = 0.985
"""Labels in eight bits; the others are those that the network itself is unsure of."""


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


def export_onnx(
    members: Sequence[Checkpoint],
    path: Path,
    azimuth_views: int = 1,
    temperature: float = 1.0,
    calibration: Shown | None = None,
    staggered: bool = False,
) -> Fidelity:
    """Write a classifier for ONNX Runtime.

    Args:
        members: The trained network; several are a committee, whose logits are averaged.
        path: The file to write.
        azimuth_views: Grids an object that the classifier averages over.
        temperature: Divides the logits.
        calibration: Inputs of training objects, at least two; with them the convolutions compute
            in eight bits.
        staggered: Cells of these grids also begin at other heights and are of other sizes.

    Returns:
        What was found on random grids; in eight bits, on every second grid of `calibration`, the
        others having set the ranges.

    Raises:
        InputError: Views or temperature out of range, or views that can not be staggered; members
            of different tasks; or eight bits are asked of networks without convolutions.
        CircumspectError: The file answers otherwise than the networks; it is not kept.
        OutputError: The file can not be written.
    """
    _require_same_task(members)
    if calibration is not None:
        require_convolutions(members)
    nets = [member.build() for member in members]
    joined = nets[0] if len(nets) == 1 else Committee(nets)
    recipe = members[0].recipe.with_views(azimuth_views, staggered)
    net = _AsStored(joined).eval()
    if recipe.takes_context:
        assert isinstance(recipe, GridRecipe)
        net = _StatesAsStored(joined, recipe.visibility).eval()
    description = {
        "format": FORMAT,
        "name": " + ".join(member.net for member in members),
        "classes": list(members[0].classes),
        "grid": recipe.to_dict(),
        "temperature": checked_temperature(temperature),
        "training": _training(members),
    }
    if OTHER in description["classes"]:
        description["other"] = OTHER
    probe = _probe(recipe) if calibration is None else calibration.every_second(1)
    network = _converted(net, _probe(recipe), recipe)
    if calibration is not None:
        if len(calibration.inputs) < 2:
            raise InputError("eight bits need two grids or more to be measured on")
        network = in_eight_bits(network, calibration.every_second(0).arrays)
    describe(network, description)
    _forget_sources(network)
    onnx.checker.check_model(network)
    add_features(network)
    with atomic_path(path) as aside:
        onnx.save(network, aside, "protobuf")
        fidelity = _fidelity(net, aside, probe)
        _require_faithful(path, fidelity, eight_bits=calibration is not None)
    return fidelity


def _require_faithful(path: Path, fidelity: Fidelity, eight_bits: bool) -> None:
    """In floating point the logits must be the same, in eight bits the labels."""
    if not eight_bits and not fidelity.difference < TOLERANCE:
        raise CircumspectError(
            f"{path}: not kept, its answers differ from the networks' by {fidelity.difference:.2g}"
        )
    if eight_bits and not fidelity.agreement >= AGREEMENT:
        raise CircumspectError(
            f"{path}: not kept, in eight bits only {fidelity.agreement:.1%} of the grids keep "
            "their label"
        )


def _require_same_task(members: Sequence[Checkpoint]) -> None:
    """Members name the same classes from the same grids and held the same objects back."""
    if not members:
        raise InputError("there is no network to export")
    first, *others = [
        (member.classes, member.recipe, member.training.get("data"), _held_back(member))
        for member in members
    ]
    if any(other != first for other in others):
        raise InputError(
            "a committee's members must share classes, grids, training data and validation split"
        )


def _held_back(member: Checkpoint) -> tuple[Any, Any]:
    settings = member.training.get("settings", {})
    return settings.get("validation"), settings.get("validation_salt")


def _training(members: Sequence[Checkpoint]) -> dict[str, Any]:
    """How the first was trained, and the others beside it, who had the same objects."""
    first, *others = [dict(member.training) for member in members]
    for other in others:
        other.pop(OBJECTS, None)
    return {**first, "others": others} if others else first


def _input_name(recipe: InputRecipe) -> str:
    return "points" if isinstance(recipe, PointsRecipe) else "grid"


def _converted(net: nn.Module, probe: Shown, recipe: InputRecipe) -> onnx.ModelProto:
    examples = tuple(torch.from_numpy(array[:2]) for array in probe.arrays)
    names = [_input_name(recipe), "context"][: len(examples)]
    axes = {0: torch.export.Dim("objects")}
    exporter_log = logging.getLogger("torch.onnx")
    level = exporter_log.level
    exporter_log.setLevel(logging.ERROR)
    try:
        with ignored_warnings():
            program = torch.onnx.export(
                net,
                examples,
                input_names=names,
                output_names=[LOGITS],
                opset_version=OPSET,
                dynamo=True,
                dynamic_shapes=dict.fromkeys(("given", "context")[: len(examples)], axes),
                verbose=False,
            )
    finally:
        exporter_log.setLevel(level)
    assert program is not None
    return program.model_proto


def _forget_sources(network: onnx.ModelProto) -> None:
    """Drop the exporter's notes on each node: they name the files it ran from."""
    for node in network.graph.node:
        del node.metadata_props[:]
        node.doc_string = ""
    for value in (*network.graph.value_info, *network.graph.input, *network.graph.output):
        del value.metadata_props[:]
    network.doc_string = ""
    network.graph.doc_string = ""
    del network.graph.metadata_props[:]


def _probe(recipe: InputRecipe) -> Shown:
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


def _fidelity(net: nn.Module, path: Path, probe: Shown) -> Fidelity:
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [taken.name for taken in session.get_inputs()]
    actual = np.asarray(session.run([LOGITS], dict(zip(names, probe.arrays, strict=True)))[0])
    with torch.no_grad():
        expected = net(*map(torch.from_numpy, probe.arrays)).numpy()
    same = actual.argmax(axis=1) == expected.argmax(axis=1)
    largest = max(1.0, float(np.abs(expected).max()))
    return Fidelity(float(np.abs(actual - expected).max()) / largest, float(same.mean()))
