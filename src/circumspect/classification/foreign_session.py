"""A network of another program, with the inputs and outputs of those that are exported here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from circumspect.classification.input_spec_file import AXES, InputSpecFile
from circumspect.errors import WeightsError

SCORES = "scores"
TYPES: Mapping[str, DTypeLike] = MappingProxyType(
    {
        "tensor(float)": np.float32,
        "tensor(float16)": np.float16,
        "tensor(double)": np.float64,
        "tensor(uint8)": np.uint8,
        "tensor(int8)": np.int8,
        "tensor(int32)": np.int32,
        "tensor(int64)": np.int64,
        "tensor(bool)": np.bool_,
    }
)
FLOATS = ("tensor(float)", "tensor(float16)", "tensor(double)")
TOLERANCE = 1e-2
"""Largest difference of summed probabilities from 1; eight-bit networks need it."""


class Value(NamedTuple):
    """An input or output as ONNX Runtime describes it."""

    name: str
    type: str
    shape: list[Any]


class ForeignSession:
    """Runs a network of another program as its input specification says.

    It has the methods of an ONNX Runtime session that `OnnxClassifier` calls.
    """

    def __init__(self, session: Any, spec: InputSpecFile) -> None:
        """Check the specification against the network.

        Args:
            session: Of ONNX Runtime.
            spec: What its file says.

        Raises:
            WeightsError: The network takes or gives something else; the message says what.
        """
        self._session, self._spec = session, spec
        self._taken = _chosen(session.get_inputs(), spec.input_name, "input")
        if len(session.get_inputs()) > 1:
            names = ", ".join(repr(value.name) for value in session.get_inputs())
            raise WeightsError(f"takes the inputs {names}; networks with one input can be run")
        self._given = _chosen(session.get_outputs(), spec.output_name, "output")
        axes = AXES[spec.input_spec.kind]
        self._axes = [axes.index(axis) for axis in spec.layout]
        self._single = self._check_input()
        self._check_output()
        zeros = np.zeros((1, *spec.input_spec.input_shape), np.float32)
        self.run([SCORES], {self._taken.name: zeros})

    def get_inputs(self) -> list[Value]:
        """One, in the order of axes of this package."""
        return [Value(self._taken.name, "", [None, *self._spec.input_spec.input_shape])]

    def get_outputs(self) -> list[Value]:
        """One: logits."""
        return [Value(SCORES, "tensor(float)", [None, len(self._spec.classes)])]

    def run(
        self, names: Sequence[str], feed: Mapping[str, NDArray[Any]]
    ) -> list[NDArray[np.float32]]:
        """Logits of some inputs.

        Args:
            names: Of the outputs; each is `SCORES`.
            feed: The input's name to (n, *input_shape).

        Returns:
            (n, c) for each name.

        Raises:
            WeightsError: The network fails, or gives something else than the specification says.
        """
        (inputs,) = feed.values()
        size = 1 if self._single else len(inputs)
        parts = [self._arranged(inputs[i : i + size]) for i in range(0, len(inputs), size)]
        try:
            found = [
                self._session.run([self._given.name], {self._taken.name: part})[0] for part in parts
            ]
        # ONNX Runtime's errors share no base class.
        except Exception as error:
            raise WeightsError(
                f"can not be run on inputs of shape {list(parts[0].shape)}; compare input.shape "
                "and input.layout with the network"
            ) from error
        expected = (size, len(self._spec.classes))
        if shape := next((np.shape(one) for one in found if np.shape(one) != expected), None):
            raise WeightsError(
                f"gives values of shape {list(shape)} for {expected[0]} inputs, but "
                f"{expected[1]} classes are named"
            )
        return [self._logits(np.concatenate(found).astype(np.float32))] * len(names)

    def _arranged(self, inputs: NDArray[Any]) -> NDArray[Any]:
        """Inputs in the order of axes and the type of the network."""
        if "C" not in self._spec.layout:
            # The channel is the second axis here.
            axes = [axis - (axis > 1) for axis in self._axes]
            inputs = inputs[:, 0]
        else:
            axes = self._axes
        return np.ascontiguousarray(np.transpose(inputs, axes), dtype=TYPES[self._taken.type])

    def _logits(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        if not np.isfinite(values).all():
            raise WeightsError("gives values that are not finite")
        if self._spec.values == "logits":
            return values
        sums = values.sum(axis=1)
        if values.min() < -TOLERANCE or np.abs(sums - 1.0).max() > TOLERANCE:
            worst = sums[np.abs(sums - 1.0).argmax()]
            raise WeightsError(
                f"gives values from {values.min():.3g} on that sum to {worst:.3g}; those are no "
                "probabilities: say output.values = logits"
            )
        return np.log(np.maximum(values, np.finfo(np.float32).tiny))

    def _check_input(self) -> bool:
        """Compare the input; says whether the network takes a single input at once."""
        layout, name = self._spec.layout, self._taken.name
        if self._taken.type not in TYPES:
            raise WeightsError(f"the input '{name}' is a {self._taken.type}, which is not numbers")
        actual = list(self._taken.shape)
        if len(actual) != len(layout):
            raise WeightsError(
                f"the input '{name}' has {len(actual)} axes {actual}, but input.layout {layout} "
                f"has {len(layout)}"
            )
        shape = (None, *self._spec.input_spec.input_shape)
        lengths = dict(zip(AXES[self._spec.input_spec.kind], shape, strict=True))
        for axis, length in zip(layout, actual, strict=True):
            if axis != "N" and isinstance(length, int) and length != lengths[axis]:
                raise WeightsError(
                    f"axis {axis} of the input '{name}' {actual} has a length of {length}, but "
                    f"the input specification says {lengths[axis]}"
                )
        batch = actual[layout.index("N")]
        if isinstance(batch, int) and batch != 1:
            raise WeightsError(
                f"takes {batch} inputs at once; export it with one, or with any number of them"
            )
        return batch == 1

    def _check_output(self) -> None:
        name, actual, classes = self._given.name, list(self._given.shape), len(self._spec.classes)
        if self._given.type not in FLOATS:
            raise WeightsError(
                f"the output '{name}' is a {self._given.type}; logits or probabilities are needed"
            )
        if len(actual) != 2 or (isinstance(actual[1], int) and actual[1] != classes):
            raise WeightsError(
                f"the output '{name}' has the shape {actual}, but {classes} classes are named"
            )


def _chosen(values: Sequence[Any], name: str | None, kind: str) -> Any:
    """The input or output of a name, or the only one.

    Raises:
        WeightsError: There is none of that name, or several and no name.
    """
    names = ", ".join(repr(value.name) for value in values)
    if name is None:
        if len(values) != 1:
            raise WeightsError(f"has the {kind}s {names}; name one by {kind}.name")
        return values[0]
    found = [value for value in values if value.name == name]
    if not found:
        raise WeightsError(f"has no {kind} {name!r:.60}; its {kind}s: {names}")
    return found[0]
