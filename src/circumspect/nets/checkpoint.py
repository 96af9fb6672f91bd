"""Weights on disk: safetensors, with all that is needed to use them in the header."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from torch import Tensor, nn

from circumspect.classification import InputRecipe, recipe_from_dict
from circumspect.classification.model_description import checked_classes, require_training_record
from circumspect.errors import InputError, WeightsError, printable
from circumspect.nets.registry import build_net, require_known
from circumspect.nets.tensor_file import save_tensors

HEADER = "circumspect"
MOST_INPUTS = 1 << 24
"""Of one object: 256 cells along each axis. The weights of some networks fit any number."""
_LONGEST = 300


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A trained network.

    Attributes:
        net: Its name in the registry.
        classes: Class names in the order of its outputs.
        recipe: What it was shown.
        weights: Parameter and buffer tensors by name.
        training: How it was trained, as JSON types: `settings`, what was `reached`, `data`, the
            digest of the set, and `objects`, the names of those that were not held back.
    """

    net: str
    classes: tuple[str, ...]
    recipe: InputRecipe
    weights: Mapping[str, Tensor]
    training: Mapping[str, Any] = field(default_factory=dict)

    def build(self) -> nn.Module:
        """The network, in evaluation mode.

        Raises:
            WeightsError: The weights do not fit the network of that name.
            InputError: There is no network of that name, or it does not take such inputs.
        """
        self._require_fitting()
        module = build_net(self.net, len(self.classes), self.recipe)
        try:
            module.load_state_dict(dict(self.weights))
        except RuntimeError as error:
            raise self._misfit() from error
        return module.eval()

    def _require_fitting(self) -> None:
        """Compare names and shapes before a network of the described size is allocated."""
        with torch.device("meta"):
            described = build_net(self.net, len(self.classes), self.recipe).state_dict()
        shapes = {name: value.shape for name, value in self.weights.items()}
        if shapes != {name: value.shape for name, value in described.items()}:
            raise self._misfit()

    def _misfit(self) -> WeightsError:
        return WeightsError(f"the weights do not fit the network '{self.net}' of this version")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file.

        Raises:
            OutputError: It can not be written.
        """
        header = {
            "net": self.net,
            "classes": list(self.classes),
            "grid": self.recipe.to_dict(),
            "training": dict(self.training),
        }
        save_tensors(path, self.weights, {HEADER: json.dumps(header)})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Checkpoint:
        """Read what `save` wrote.

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
            recipe = recipe_from_dict(header["grid"])
            if math.prod(recipe.input_shape) > MOST_INPUTS:
                raise ValueError(f"inputs of more than {MOST_INPUTS} numbers")
            if broken := [name for name, value in weights.items() if not value.isfinite().all()]:
                raise ValueError(f"{broken[0]} holds numbers that are not finite")
            checkpoint = cls(
                header["net"],
                checked_classes(header["classes"]),
                recipe,
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
    return printable(str(error).partition("\n")[0][:_LONGEST])
