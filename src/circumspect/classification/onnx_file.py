"""Opening the file of a classifier."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from circumspect.classification.model_description import METADATA_KEY
from circumspect.classification.onnx_inspection import (
    LARGEST_FILE,
    bound_memory,
    require_plain_network,
)
from circumspect.classification.shipped import shipped_path, unknown_model
from circumspect.errors import InputError, WeightsError, reason_of

MOST_THREADS = 1024


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
    """The content of a user's file, in which nothing but a plain network was found.

    Raises:
        WeightsError: No such file or shipped classifier, or one that can not be run.
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
        if path.is_file() and path.stat().st_size > LARGEST_FILE:
            raise WeightsError(f"{path}: larger than {LARGEST_FILE >> 20} MiB; no network here is")
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

    if not 0 <= threads <= MOST_THREADS:
        raise InputError(f"threads must be 0 (all cores) to {MOST_THREADS}, not {threads}")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    # Threads that wait would keep the cores from the stages before and after.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 4
    if foreign:
        bound_memory()
        options.add_session_config_entry("session.use_env_allocators", "1")
    try:
        session = onnxruntime.InferenceSession(content, options, ["CPUExecutionProvider"])
    # ONNX Runtime's faults share no base class of their own.
    except Exception as error:
        raise WeightsError(
            f"{name}: not an ONNX network; make one with circumspect export"
        ) from error
    return session


def description_in(session: Any, name: str) -> dict[str, Any] | None:
    """What a file says of itself; None where it is of another program.

    Args:
        session: Of the file.
        name: Of the file, for messages.

    Raises:
        WeightsError: Its description is broken.
    """
    try:
        text = session.get_modelmeta().custom_metadata_map.get(METADATA_KEY)
    except UnicodeDecodeError as error:
        raise WeightsError(f"{name}: its description is no text; export it anew") from error
    try:
        return None if text is None else json.loads(text)
    except (ValueError, RecursionError) as error:
        raise broken_description(name, error) from error


def broken_description(name: str, error: Exception) -> WeightsError:
    """The error of a file whose description can not be used."""
    return WeightsError(f"{name}: its description is broken ({error}); export it anew")
