"""Tensors on disk as safetensors: written aside, then renamed, like every result."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Mapping

from safetensors import SafetensorError
from safetensors.torch import save_file
from torch import Tensor

from circumspect.storage import atomic_path


def save_tensors(
    path: str | os.PathLike[str], tensors: Mapping[str, Tensor], header: Mapping[str, str]
) -> None:
    """Write tensors by name, with text beside them.

    Args:
        path: The file.
        tensors: That share no memory.
        header: Text by key.

    Raises:
        OutputError: The file can not be written.
    """
    contiguous = {name: value.contiguous() for name, value in tensors.items()}
    with atomic_path(path) as aside:
        mode = stat.S_IMODE(aside.stat().st_mode)
        try:
            save_file(contiguous, aside, dict(header))
        except SafetensorError as error:
            raise _as_system_error(error) from error
        # The library puts a file of its own there, which no one else may read.
        aside.chmod(mode)


def _as_system_error(error: SafetensorError) -> OSError:
    """What the system said: the library tells it as text alone."""
    if code := re.search(r"\(os error (\d+)\)", str(error)):
        return OSError(int(code[1]), os.strerror(int(code[1])))
    return OSError(str(error))
