"""Convolutions in eight bits, which a robot's CPU computes faster."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnxruntime.quantization import (
    CalibrationDataReader,
    QuantFormat,
    QuantType,
    quantize_static,
)
from onnxruntime.quantization.shape_inference import quant_pre_process
from torch import nn

from circumspect.errors import InputError
from circumspect.nets import Checkpoint

BATCH = 16
CONVOLUTIONS = (nn.Conv1d, nn.Conv2d, nn.Conv3d)


def require_convolutions(members: Sequence[Checkpoint]) -> None:
    """Find out before long work whether eight bits would change anything.

    Args:
        members: The networks that are to be exported together.

    Raises:
        InputError: None of them has a convolution.
    """
    layers = (layer for member in members for layer in member.build().modules())
    if not any(isinstance(layer, CONVOLUTIONS) for layer in layers):
        names = " + ".join(member.net for member in members)
        raise InputError(f"{names} has no convolutions to quantise; leave out --int8")


def in_eight_bits(network: onnx.ModelProto, inputs: NDArray[Any]) -> onnx.ModelProto:
    """Quantise the convolutions of a network.

    Weights get seven bits, each output channel a scale of its own, so that CPUs without VNNI do
    not saturate; activations get eight, over the range that the given inputs lead to.

    Args:
        network: In floating point, with one input.
        inputs: (n, *shape) of training objects: what the ranges are measured on.

    Returns:
        The network; its metadata are not kept.
    """
    with TemporaryDirectory() as folder, _quiet():
        given, plain, quantised = (Path(folder) / f"{step}.onnx" for step in range(3))
        # As a file: the preprocessor can not read back how it stores a network in memory.
        onnx.save(network, given, "protobuf")
        quant_pre_process(given, plain, skip_symbolic_shape=True)
        quantize_static(
            plain,
            quantised,
            _Batches(network.graph.input[0].name, inputs),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=["Conv"],
            per_channel=True,
            reduce_range=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
        )
        return onnx.load(quantised)


class _Batches(CalibrationDataReader):
    def __init__(self, name: str, inputs: NDArray[Any]) -> None:
        self._name = name
        self._parts: Iterator[NDArray[Any]] = iter(np.array_split(inputs, -(-len(inputs) // BATCH)))

    def get_next(self) -> Any:
        """The next batch; None after the last."""
        part = next(self._parts, None)
        return None if part is None else {self._name: part}


@contextmanager
def _quiet() -> Iterator[None]:
    """The quantiser warns at the root logger about steps that were taken."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)
