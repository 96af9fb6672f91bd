"""Checkpoints: safetensors files whose header contains everything needed to use the weights."""

from __future__ import annotations

import json
import math
import os
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

from circumspect.classification import InputSpec, input_spec_from_dict
from circumspect.classification.model_description import checked_classes, require_training_record
from circumspect.errors import InputError, WeightsError, printable
from circumspect.nets.registry import build_net, require_known
from circumspect.storage import atomic_path

HEADER = "circumspect"
MAX_INPUT_NUMBERS = 1 << 24
"""Maximum input of one object, 256 cells along each axis; some networks accept any number."""
_MAX_REASON_LENGTH = 300


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A trained network.

    Attributes:
        net: Name of the network in the registry.
        classes: Class names in the order of the outputs.
        input_spec: Input specification.
        weights: Parameter and buffer tensors by name.
        training: Record of the training, JSON types: `settings`, the metrics `reached`, `data` (the
            digest of the set) and `objects` (the names of the training objects).
    """

    net: str
    classes: tuple[str, ...]
    input_spec: InputSpec
    weights: Mapping[str, Tensor]
    training: Mapping[str, Any] = field(default_factory=dict)

    def build(self) -> nn.Module:
        """Build the network, in evaluation mode.

        Raises:
            WeightsError: The weights do not match the network.
            InputError: There is no network of that name, or it does not take such inputs.
        """
        self._require_fitting()
        module = build_net(self.net, len(self.classes), self.input_spec)
        try:
            module.load_state_dict(dict(self.weights))
        except RuntimeError as error:
            raise self._mismatch() from error
        return module.eval()

    def _require_fitting(self) -> None:
        """Compare names and shapes before a network of the described size is allocated."""
        with torch.device("meta"):
            described = build_net(self.net, len(self.classes), self.input_spec).state_dict()
        shapes = {name: value.shape for name, value in self.weights.items()}
        if shapes != {name: value.shape for name, value in described.items()}:
            raise self._mismatch()

    def _mismatch(self) -> WeightsError:
        return WeightsError(f"the weights do not fit the network '{self.net}' of this version")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the checkpoint.

        Raises:
            OutputError: The file cannot be written.
        """
        header = {
            "net": self.net,
            "classes": list(self.classes),
            "grid": self.input_spec.to_dict(),
            "training": dict(self.training),
        }
        save_tensors(path, self.weights, {HEADER: json.dumps(header)})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Checkpoint:
        """Read a checkpoint from `save`.

        Raises:
            WeightsError: The file is missing, broken, of another program, or of a network that is
                not installed.
        """
        if not Path(path).is_file():
            raise WeightsError(f"{path}: no such file")
        try:
            with safe_open(path, framework="pt") as stream:
                header = json.loads((stream.metadata() or {})[HEADER])
                weights = {name: stream.get_tensor(name) for name in stream.keys()}  # noqa: SIM118
            if not isinstance(header["net"], str):
                raise ValueError("the network's name is no text")
            require_training_record(header["training"])
            input_spec = input_spec_from_dict(header["grid"])
            if math.prod(input_spec.input_shape) > MAX_INPUT_NUMBERS:
                raise ValueError(f"inputs of more than {MAX_INPUT_NUMBERS} numbers")
            if broken := [name for name, value in weights.items() if not value.isfinite().all()]:
                raise ValueError(f"{broken[0]} holds numbers that are not finite")
            checkpoint = cls(
                header["net"],
                checked_classes(header["classes"]),
                input_spec,
                weights,
                header["training"],
            )
        except (
            SafetensorError,
            OSError,
            ValueError,
            KeyError,
            TypeError,
            AttributeError,
            OverflowError,
            RuntimeError,
            MemoryError,
            InputError,
        ) as error:
            raise WeightsError(
                f"{path}: not a checkpoint of circumspect ({_first_line(error)})"
            ) from error
        require_known(checkpoint.net, path)
        return checkpoint


def _first_line(error: BaseException) -> str:
    return printable(str(error).partition("\n")[0][:_MAX_REASON_LENGTH])


def save_tensors(
    path: str | os.PathLike[str], tensors: Mapping[str, Tensor], header: Mapping[str, str]
) -> None:
    """Write tensors and text.

    Args:
        path: The file.
        tensors: Tensors by name, which must not share memory.
        header: Texts by key.

    Raises:
        OutputError: The file cannot be written.
    """
    contiguous = {name: value.contiguous() for name, value in tensors.items()}
    with atomic_path(path) as temporary:
        mode = stat.S_IMODE(temporary.stat().st_mode)
        try:
            save_file(contiguous, temporary, dict(header))
        except SafetensorError as error:
            raise _as_system_error(error) from error
        # The library creates a file that only its owner can read.
        temporary.chmod(mode)


def _as_system_error(error: SafetensorError) -> OSError:
    """The underlying OSError, which the library reports as text."""
    if code := re.search(r"\(os error (\d+)\)", str(error)):
        return OSError(int(code[1]), os.strerror(int(code[1])))
    return OSError(str(error))
