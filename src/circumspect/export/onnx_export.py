"""Export checkpoints as ONNX files whose answers are verified."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import torch
from torch import nn

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.classification.context import WIDTH
from circumspect.classification.model_description import FORMAT, OBJECTS, checked_temperature
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.errors import CircumspectError, InputError
from circumspect.export.conversion import NetworkInputs, as_onnx, taking_stored_inputs
from circumspect.export.description import describe
from circumspect.export.eight_bit import in_eight_bits, require_convolutions
from circumspect.export.features import LOGITS, add_features
from circumspect.grid.grid import FREE, OCCUPIED
from circumspect.nets import Checkpoint
from circumspect.nets.committee import Committee
from circumspect.storage import atomic_path

TOLERANCE = 1e-4
"""Largest difference of the logits in floating point; see `Fidelity`."""
AGREEMENT = 0.985
"""Smallest fraction of unchanged labels in eight bits; see `Fidelity`."""


@dataclass(frozen=True)
class Fidelity:
    """Agreement of an exported file with its networks.

    Attributes:
        difference: The largest difference between their logits, relative to the largest logit if
            that is above 1.
        agreement: Fraction of the inputs with the same label.
    """

    difference: float
    agreement: float


def fidelity_of(net: nn.Module, path: Path, probe: NetworkInputs) -> Fidelity:
    """Compare a file with its network.

    Args:
        net: Takes inputs as they are stored.
        path: The ONNX file.
        probe: Inputs for both.
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
    """Check the agreement: of the logits in floating point, of the labels in eight bits.

    Raises:
        CircumspectError: They differ.
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


def random_inputs(input_spec: InputSpec) -> NetworkInputs:
    """Random grids of several densities, including empty and full ones; or random points."""
    rng = np.random.default_rng(0)
    if isinstance(input_spec, PointsSpec):
        return NetworkInputs(
            rng.uniform(-0.7, 0.7, (6, *input_spec.input_shape)).astype(np.float32)
        )
    densities = np.array([0.0, 0.01, 0.03, 0.1, 0.3, 1.0])[:, None, None, None, None]
    occupied = (rng.random((6, *input_spec.input_shape)) < densities).astype(np.uint8)
    if not input_spec.takes_context:
        return NetworkInputs(occupied)
    free = rng.random(occupied.shape) < 0.3
    states = np.where(occupied, np.uint8(OCCUPIED), np.uint8(FREE) * free).astype(np.uint8)
    assert isinstance(input_spec, GridSpec)
    contexts = rng.uniform(-1.0, 1.0, (6, WIDTH)).astype(np.float32)
    return NetworkInputs(states if input_spec.visibility else occupied, contexts)


def export_onnx(
    members: Sequence[Checkpoint],
    path: Path,
    azimuth_views: int = 1,
    temperature: float = 1.0,
    calibration: NetworkInputs | None = None,
    dithered: bool = False,
) -> Fidelity:
    """Write a classifier for ONNX Runtime.

    Args:
        members: The trained network; several are a committee, whose logits are averaged.
        path: The file to write.
        azimuth_views: Grids per object that the classifier averages over.
        temperature: Divides the logits.
        calibration: Inputs of training objects, at least two; with them the convolutions are
            quantised to eight bits.
        dithered: Grids also have sub-cell offsets in height and other sizes.

    Returns:
        The agreement on random grids; in eight bits, on every second grid of `calibration`, while
        the others set the ranges.

    Raises:
        InputError: Views or temperature out of range, or views that cannot be dithered; members of
            different tasks; or eight bits for networks without convolutions.
        CircumspectError: The file gives other answers than the networks; it is not kept.
        OutputError: The file cannot be written.
    """
    _require_same_task(members)
    if calibration is not None:
        require_convolutions(members)
        if len(calibration.inputs) < 2:
            raise InputError("eight bits need two grids or more to be measured on")
    input_spec = members[0].input_spec.with_views(azimuth_views, dithered)
    description = _description(members, input_spec, temperature)
    net = taking_stored_inputs(_joined(members), input_spec)
    probe = random_inputs(input_spec) if calibration is None else calibration.every_second(1)
    network = as_onnx(net, random_inputs(input_spec), input_spec)
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
    members: Sequence[Checkpoint], input_spec: InputSpec, temperature: float
) -> dict[str, Any]:
    """The description in the file."""
    first = members[0]
    described = {
        "format": FORMAT,
        "name": " + ".join(member.net for member in members),
        "classes": list(first.classes),
        "grid": input_spec.to_dict(),
        "temperature": checked_temperature(temperature),
        "training": _training(members),
    }
    return {**described, "other": OTHER} if OTHER in first.classes else described


def _require_same_task(members: Sequence[Checkpoint]) -> None:
    """Check that members have the same classes, grids and held-back objects."""
    if not members:
        raise InputError("there is no network to export")
    first, *others = [
        (member.classes, member.input_spec, member.training.get("data"), _held_back(member))
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
    """Training record of the first, with those of the others, which have the same objects."""
    first, *others = [dict(member.training) for member in members]
    for other in others:
        other.pop(OBJECTS, None)
    return {**first, "others": others} if others else first
