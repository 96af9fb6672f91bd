"""Quantise convolutions and the operators between them to eight bits, which is faster on a CPU."""

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
STEPS = ["Conv", "Relu", "Add", "Concat", "Slice", "Transpose", "Reshape"]
"""Quantised operators. Those between convolutions are included, since conversions to floats and
back take longer than many a convolution."""


def require_convolutions(members: Sequence[Checkpoint]) -> None:
    """Check before a long run whether a network has convolutions to quantise.

    Args:
        members: The networks that are to be exported together.

    Raises:
        InputError: None of them has a convolution.
    """
    layers = (layer for member in members for layer in member.build().modules())
    if not any(isinstance(layer, CONVOLUTIONS) for layer in layers):
        names = " + ".join(member.net for member in members)
        raise InputError(f"{names} has no convolutions to quantise; leave out --int8")


def in_eight_bits(network: onnx.ModelProto, inputs: Sequence[NDArray[Any]]) -> onnx.ModelProto:
    """Quantise the convolutions of a network and the operators between them.

    Weights get seven bits with a scale per output channel, so that CPUs without VNNI do not
    saturate. Activations get eight bits over the range that the given inputs lead to.

    Args:
        network: In floating point.
        inputs: (n, …) of training objects for each of its inputs: what the ranges are measured on.

    Returns:
        The network; its metadata are not kept.
    """
    with TemporaryDirectory() as folder, _quiet():
        given, plain, quantised = (Path(folder) / f"{step}.onnx" for step in range(3))
        # Through a file: the preprocessor can not read its own networks from memory.
        onnx.save(network, given, "protobuf")
        quant_pre_process(given, plain, skip_symbolic_shape=True)
        quantize_static(
            plain,
            quantised,
            _Batches([given.name for given in network.graph.input], inputs),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=STEPS,
            per_channel=True,
            reduce_range=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
        )
        return onnx.load(quantised)


class _Batches(CalibrationDataReader):
    def __init__(self, names: Sequence[str], inputs: Sequence[NDArray[Any]]) -> None:
        parts = [np.array_split(array, -(-len(array) // BATCH)) for array in inputs]
        self._batches: Iterator[dict[str, NDArray[Any]]] = (
            dict(zip(names, batch, strict=True)) for batch in zip(*parts, strict=True)
        )

    def get_next(self) -> Any:
        """The next batch; None after the last."""
        return next(self._batches, None)


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the quantiser's warnings at the root logger about steps that were taken."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)
