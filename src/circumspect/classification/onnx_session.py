"""Inputs and outputs of a network in ONNX Runtime, and its execution in batches."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification.context import WIDTH
from circumspect.classification.model_description import METADATA_KEY
from circumspect.classification.onnx_inspection import (
    MAX_FILE_BYTES,
    bound_memory,
    require_plain_network,
)
from circumspect.classification.shipped import shipped_path, unknown_model
from circumspect.errors import InputError, WeightsError, reason_of

MAX_BATCH_INPUTS = 32
"""Inputs per batch: a network's memory per input is many times the input's size."""
MAX_BATCH_NUMBERS = 32 << 15
"""Numbers per batch: those of 32 grids of 32³ cells."""
MAX_THREADS = 1024


def check_shapes(
    session: Any, input_shape: Sequence[int], classes: int, takes_context: bool = False
) -> None:
    """Check that a network takes one kind of input and returns one score per class.

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
    size = max(1, min(MAX_BATCH_INPUTS, MAX_BATCH_NUMBERS // math.prod(inputs.shape[1:])))
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
    # ONNX Runtime's errors share no base class.
    except Exception as error:
        raise WeightsError(
            "these weights can not be run: the network is broken, or takes too much memory"
        ) from error
    for output in found:
        shape = np.shape(output)
        if len(shape) != 2 or len(output) != len(given[0]) or output.dtype != np.float32:
            raise WeightsError(f"these weights give {shape} numbers for {len(given[0])} inputs")
    return found


def shipped_network(name: str) -> bytes:
    """The content of a shipped classifier's file.

    Raises:
        WeightsError: It is missing.
    """
    try:
        return shipped_path(name).read_bytes()
    except OSError as error:
        raise WeightsError(
            f"the shipped classifier '{name}' is missing; install circumspect again"
        ) from error


def foreign_network(model: str | os.PathLike[str]) -> bytes:
    """The content of a user's file that was checked to be a plain network.

    Raises:
        WeightsError: No such file or shipped classifier, or one that cannot be run.
    """
    content = _read(model)
    try:
        require_plain_network(content)
    except WeightsError as error:
        raise WeightsError(
            f"{model}: not an ONNX network that can be run ({error}); make one with "
            "circumspect export"
        ) from error
    return content


def _read(model: str | os.PathLike[str]) -> bytes:
    path = Path(model)
    try:
        if not os.fspath(model):
            raise FileNotFoundError
        if path.is_dir():
            raise WeightsError(
                f"{path}: is a folder; where a network was trained in it, circumspect export "
                "makes the ONNX file that is needed here"
            )
        if path.exists() and not path.is_file():
            raise WeightsError(f"{path}: can not be read (not a regular file)")
        if path.is_file() and path.stat().st_size > MAX_FILE_BYTES:
            raise WeightsError(
                f"{path}: larger than {MAX_FILE_BYTES >> 20} MiB; no network here is"
            )
        return path.read_bytes()
    except FileNotFoundError as error:
        raise unknown_model(model) from error
    except OSError as error:
        raise WeightsError(f"{path}: can not be read ({reason_of(error)})") from error


def open_session(content: bytes, name: str, threads: int, foreign: bool = False) -> Any:
    """An inference session.

    Args:
        content: Of the file.
        name: Of the file, for messages.
        threads: For one answer; 0 means all cores.
        foreign: The memory that it may take is bounded.

    Raises:
        InputError: Threads out of range.
        WeightsError: Not a network.
    """
    import onnxruntime

    if not 0 <= threads <= MAX_THREADS:
        raise InputError(f"threads must be 0 (all cores) to {MAX_THREADS}, not {threads}")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    # Spinning threads would block the cores for the stages before and after.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 4
    if foreign:
        bound_memory()
        options.add_session_config_entry("session.use_env_allocators", "1")
    try:
        # The fallback is the same; a message would appear on standard output.
        session = onnxruntime.InferenceSession(
            content, options, ["CPUExecutionProvider"], enable_fallback=0
        )
    # ONNX Runtime's errors share no base class.
    except Exception as error:
        raise WeightsError(
            f"{name}: not an ONNX network; make one with circumspect export"
        ) from error
    return session


def description_in(session: Any, name: str) -> dict[str, Any] | None:
    """The description in a file; None for a file of another program.

    Args:
        session: Of the file.
        name: Of the file, for messages.

    Raises:
        WeightsError: Its description is broken.
    """
    try:
        text = session.get_modelmeta().custom_metadata_map.get(METADATA_KEY)
    except UnicodeDecodeError as error:
        raise WeightsError(f"{name}: its description is no text; export it again") from error
    try:
        return None if text is None else json.loads(text)
    except (ValueError, RecursionError) as error:
        raise broken_description(name, error) from error


def broken_description(name: str, error: Exception) -> WeightsError:
    """The error of a file whose description cannot be used."""
    return WeightsError(f"{name}: its description is broken ({error}); export it again")
