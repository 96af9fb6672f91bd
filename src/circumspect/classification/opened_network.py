"""Opening of a network's file: a shipped one, an exported one, or one of another program."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

from circumspect.classification.foreign_session import ForeignSession
from circumspect.classification.input_spec_file import InputSpecFile, spec_paths
from circumspect.classification.model_description import LaterFormatError, ModelDescription
from circumspect.classification.onnx_session import (
    broken_description,
    check_shapes,
    description_in,
    foreign_network,
    open_session,
    shipped_network,
)
from circumspect.errors import CircumspectError, InputError, WeightsError


class OpenedNetwork(NamedTuple):
    """A network that fits its description.

    Attributes:
        session: Of ONNX Runtime, or a `ForeignSession`.
        description: See `ModelDescription.from_dict`.
    """

    session: Any
    description: dict[str, Any]


def open_shipped(name: str, threads: int = 0) -> OpenedNetwork:
    """Open a shipped classifier.

    Args:
        name: Of the classifier.
        threads: For one answer; 0 means all cores.

    Raises:
        InputError: Threads out of range.
        WeightsError: The file is missing or broken.
    """
    title = f"the classifier '{name}'"
    session = open_session(shipped_network(name), title, threads)
    return _checked(session, description_in(session, title), title)


def open_own(
    model: str | os.PathLike[str],
    threads: int = 0,
    input_spec: str | os.PathLike[str] | None = None,
) -> OpenedNetwork:
    """Open a user's file, from `circumspect export` or another program.

    Args:
        model: The ONNX file.
        threads: For one answer; 0 means all cores.
        input_spec: Input specification of a network of another program; None: the file beside it.

    Raises:
        InputError: Threads out of range, a broken input specification, or one for a network that
            needs none.
        WeightsError: The file is missing or broken, or differs from its description.
    """
    content, file = foreign_network(model), Path(model)
    session, title = open_session(content, str(file), threads, foreign=True), str(file)
    description = description_in(session, title)
    if description is None:
        return _described_beside(session, file, input_spec)
    if input_spec is not None:
        raise InputError(
            f"{input_spec}: {file} was made by circumspect export and holds its own input "
            "specification; leave this one out"
        )
    return _checked(session, description, title)


def _described_beside(
    session: Any, file: Path, input_spec: str | os.PathLike[str] | None
) -> OpenedNetwork:
    """A network of another program, as its input specification describes it."""
    given = None if input_spec is None else InputSpecFile.load(input_spec)
    spec = given or InputSpecFile.beside(file)
    if spec is None:
        beside = " or ".join(path.name for path in spec_paths(file))
        raise WeightsError(
            f"{file}: an ONNX network of another program; describe its input in {beside}, or make "
            "one with circumspect export"
        )
    try:
        adapted = ForeignSession(session, spec)
    except WeightsError as error:
        raise WeightsError(f"{file}: {error} ({spec.path.name})") from error
    return OpenedNetwork(adapted, spec.description(file.stem))


def _checked(session: Any, description: Any, name: str) -> OpenedNetwork:
    """The network, if it fits its description."""
    try:
        described = ModelDescription.from_dict(description)
    except LaterFormatError as error:
        raise WeightsError(f"{name}: {error}") from error
    except (ValueError, KeyError, TypeError, RecursionError, CircumspectError) as error:
        raise broken_description(name, error) from error
    input_spec = described.input_spec
    try:
        check_shapes(
            session, input_spec.input_shape, len(described.outputs), input_spec.takes_context
        )
    except WeightsError as error:
        raise WeightsError(f"{name}: {error}; export it again") from error
    return OpenedNetwork(session, description)
