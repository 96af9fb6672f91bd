"""The state of an unfinished run as safetensors, so that nothing is ever unpickled."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from torch import Tensor
from torch.optim import Optimizer

from circumspect import __version__
from circumspect.errors import WeightsError
from circumspect.nets.tensor_file import save_tensors

HEADER = "circumspect_state"
VERSION = "circumspect_version"


def save_state(
    path: Path, modules: Mapping[str, torch.nn.Module], optimizer: Optimizer, progress: Any
) -> None:
    """Write modules, optimizer and progress.

    Args:
        path: The file.
        modules: By name.
        optimizer: Of one of them.
        progress: JSON types.

    Raises:
        OutputError: The file can not be written.
    """
    tensors: dict[str, Tensor] = {}
    for name, module in modules.items():
        tensors |= {f"{name}/{key}": value.clone() for key, value in module.state_dict().items()}
    for index, slots in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer/{index}/{key}": torch.as_tensor(v) for key, v in slots.items()}
    save_tensors(path, tensors, {HEADER: json.dumps(progress), VERSION: __version__})


def state_version(path: Path) -> str | None:
    """Which version of the package wrote a state; None where it is of before states told.

    Raises:
        WeightsError: The file is broken.
    """
    try:
        with safe_open(path, framework="pt") as stream:
            return (stream.metadata() or {}).get(VERSION)
    except (SafetensorError, OSError) as error:
        raise _unusable(path) from error


def load_state(
    path: Path, modules: Mapping[str, torch.nn.Module], optimizer: Optimizer, device: torch.device
) -> Any:
    """Read what `save_state` wrote back into the modules and the optimizer.

    Returns:
        The progress.

    Raises:
        WeightsError: The file is broken or belongs to another network.
    """
    try:
        with safe_open(path, framework="pt", device=str(device)) as stream:
            progress = json.loads((stream.metadata() or {})[HEADER])
            tensors = {name: stream.get_tensor(name) for name in stream.keys()}  # noqa: SIM118
        for name, module in modules.items():
            module.load_state_dict(_below(tensors, name))
        _restore(optimizer, _below(tensors, "optimizer"))
    except (
        SafetensorError, OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError
    ) as error:  # fmt: skip
        raise _unusable(path) from error
    return progress


def _unusable(path: Path) -> WeightsError:
    return WeightsError(f"{path}: can not be resumed from; start with another --out")


def _restore(optimizer: Optimizer, tensors: Mapping[str, Tensor]) -> None:
    slots: dict[int, dict[str, Tensor]] = {}
    for name, value in tensors.items():
        index, key = name.split("/")
        slots.setdefault(int(index), {})[key] = value
    groups = optimizer.state_dict()["param_groups"]
    optimizer.load_state_dict({"state": slots, "param_groups": groups})


def _below(tensors: Mapping[str, Tensor], name: str) -> dict[str, Tensor]:
    start = f"{name}/"
    return {key[len(start) :]: value for key, value in tensors.items() if key.startswith(start)}
