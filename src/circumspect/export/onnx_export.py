"""Checkpoints as ONNX, kept only if the file answers as they do."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import onnx
from torch import nn

from circumspect.classification import InputRecipe
from circumspect.classification.model_description import FORMAT, OBJECTS, checked_temperature
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.errors import InputError
from circumspect.export.conversion import as_onnx
from circumspect.export.description import describe
from circumspect.export.eight_bit import in_eight_bits, require_convolutions
from circumspect.export.features import add_features
from circumspect.export.fidelity import Fidelity, fidelity_of, random_inputs, require_faithful
from circumspect.export.shown import Shown
from circumspect.export.stored_inputs import taking_stored_inputs
from circumspect.nets import Checkpoint
from circumspect.nets.committee import Committee
from circumspect.storage import atomic_path


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
        if len(calibration.inputs) < 2:
            raise InputError("eight bits need two grids or more to be measured on")
    recipe = members[0].recipe.with_views(azimuth_views, staggered)
    description = _description(members, recipe, temperature)
    net = taking_stored_inputs(_joined(members), recipe)
    probe = random_inputs(recipe) if calibration is None else calibration.every_second(1)
    network = as_onnx(net, random_inputs(recipe), recipe)
    if calibration is not None:
        network = in_eight_bits(network, calibration.every_second(0).arrays)
    describe(network, description)
    onnx.checker.check_model(network)
    add_features(network)
    with atomic_path(path) as temporary:
        onnx.save(network, temporary, "protobuf")
        fidelity = fidelity_of(net, temporary, probe)
        require_faithful(path, fidelity, eight_bits=calibration is not None)
    return fidelity


def _joined(members: Sequence[Checkpoint]) -> nn.Module:
    nets = [member.build() for member in members]
    return nets[0] if len(nets) == 1 else Committee(nets)


def _description(
    members: Sequence[Checkpoint], recipe: InputRecipe, temperature: float
) -> dict[str, Any]:
    """What the file says of itself."""
    first = members[0]
    described = {
        "format": FORMAT,
        "name": " + ".join(member.net for member in members),
        "classes": list(first.classes),
        "grid": recipe.to_dict(),
        "temperature": checked_temperature(temperature),
        "training": _training(members),
    }
    return {**described, "other": OTHER} if OTHER in first.classes else described


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
