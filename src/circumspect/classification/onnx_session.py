"""What a network in ONNX Runtime takes and gives, and how many inputs it is given at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import WIDTH
from circumspect.errors import WeightsError

MOST_INPUTS = 32
"""At once: what a network remembers of each input takes many times the room of the input."""
MOST_NUMBERS = 32 << 15
"""At once, over all inputs: those of so many grids of 32³ cells."""


def check_shapes(
    session: Any, input_shape: Sequence[int], classes: int, takes_context: bool = False
) -> None:
    """That a network takes one kind of input and gives a score of each class for each.

    Args:
        session: The network.
        input_shape: Of one input.
        classes: How many its description names.
        takes_context: Whether it takes a context beside each input.

    Raises:
        WeightsError: It takes or gives something else.
    """
    taken, given = session.get_inputs(), session.get_outputs()
    wanted = 2 if takes_context else 1
    if len(taken) != wanted or not given:
        raise WeightsError(
            f"takes {len(taken)} inputs and gives {len(given)} outputs, not {wanted} and scores"
        )
    if takes_context and list(taken[1].shape)[1:] != [WIDTH]:
        raise WeightsError(f"takes a context of {list(taken[1].shape)[1:]}, not of [{WIDTH}]")
    expected, actual, scores = list(input_shape), list(taken[0].shape), list(given[0].shape)
    if given[0].type != "tensor(float)" or len(scores) != 2:
        raise WeightsError(f"gives {given[0].type} of shape {scores}, not a row of scores an input")
    if actual[1:] != expected or scores[1] != classes:
        raise WeightsError(
            f"takes {actual[1:]} and gives {scores[1]} values, but its description says "
            f"{expected} and {classes} classes"
        )


def run_in_parts(
    session: Any,
    inputs: NDArray[Any],
    outputs: Sequence[str],
    contexts: NDArray[np.float32] | None = None,
) -> list[NDArray[np.float32]]:
    """Outputs of a network for many inputs, a few of them at once.

    Args:
        session: The network.
        inputs: (n, *input_shape).
        outputs: Their names.
        contexts: (n, 6) for a network that takes them.

    Returns:
        (n, w) of each.

    Raises:
        WeightsError: The network fails, or gives something else.
    """
    size = max(1, min(MOST_INPUTS, MOST_NUMBERS // math.prod(inputs.shape[1:])))
    starts = range(0, len(inputs), size)
    given = [inputs] if contexts is None else [inputs, contexts]
    parts = [
        _run(session, [one[start : start + size] for one in given], outputs) for start in starts
    ]
    found = list(zip(*parts, strict=True))
    if any(len({part.shape[1] for part in output}) > 1 for output in found):
        raise WeightsError("these weights give now more, now fewer numbers for an input")
    return [np.concatenate(output) for output in found]


def _run(
    session: Any, given: Sequence[NDArray[Any]], outputs: Sequence[str]
) -> list[NDArray[np.float32]]:
    names = [taken.name for taken in session.get_inputs()]
    try:
        found = session.run(list(outputs), dict(zip(names, given, strict=True)))
    # ONNX Runtime's faults share no base class of their own.
    except Exception as error:
        raise WeightsError(
            "these weights can not be run: the network is broken, or takes too much memory"
        ) from error
    for output in found:
        shape = np.shape(output)
        if len(shape) != 2 or len(output) != len(given[0]) or output.dtype != np.float32:
            raise WeightsError(f"these weights give {shape} numbers for {len(given[0])} inputs")
    return found
