"""Weights on disk: safetensors, with all that is needed to use them in the header."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from torch import Tensor, nn

from circumspect.classification import InputRecipe, recipe_from_dict
from circumspect.errors import InputError, WeightsError
from circumspect.nets.registry import build_net, require_known
from circumspect.nets.tensor_file import save_tensors

HEADER = "circumspect"


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
        """
        module = build_net(self.net, len(self.classes), self.recipe)
        try:
            module.load_state_dict(dict(self.weights))
        except RuntimeError as error:
            raise WeightsError(
                f"the weights do not fit the network '{self.net}' of this version"
            ) from error
        return module.eval()

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
            if broken := [name for name, value in weights.items() if not value.isfinite().all()]:
                raise ValueError(f"{broken[0]} holds numbers that are not finite")
            checkpoint = cls(
                str(header["net"]),
                tuple(header["classes"]),
                recipe_from_dict(header["grid"]),
                weights,
                header["training"],
            )
        except (
            SafetensorError,
            OSError,
            ValueError,
            KeyError,
            TypeError,
            RecursionError,
            InputError,
        ) as error:
            raise WeightsError(f"{path}: not a checkpoint of circumspect ({error})") from error
        require_known(checkpoint.net, path)
        return checkpoint
