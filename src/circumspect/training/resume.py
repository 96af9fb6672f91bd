"""State and progress of an unfinished run as safetensors; nothing is unpickled."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from torch import Tensor
from torch.optim import Optimizer

from circumspect import __version__
from circumspect.errors import WeightsError
from circumspect.nets.checkpoint import save_tensors

HEADER = "circumspect_state"
VERSION = "circumspect_version"


@dataclass
class Progress:
    """Finished epochs and the current one.

    Attributes:
        history: One row of metrics per finished epoch.
        step: Number of finished steps of the current epoch.
        loss: Sum of the losses of these steps.
        hits: Number of objects classified correctly in these steps.
        seen: Number of objects in these steps.
        seconds: Duration of these steps [s].
        processes: Number of processes that share the epoch.
    """

    history: list[dict[str, float]]
    step: int = 0
    loss: float = 0.0
    hits: int = 0
    seen: int = 0
    seconds: float = 0.0
    processes: int = 1

    @property
    def epoch(self) -> int:
        """Number of the current epoch, from 0."""
        return len(self.history)

    def add(self, loss: float, hits: int, seen: int) -> None:
        """Count a step."""
        self.step += 1
        self.loss += loss
        self.hits += hits
        self.seen += seen

    def row(self) -> dict[str, float]:
        """Metrics of the epoch."""
        return {
            "epoch": self.epoch + 1,
            "loss": self.loss / self.step,
            "training_accuracy": self.hits / self.seen,
            "seconds": self.seconds,
        }

    def next_epoch(self, row: dict[str, float]) -> Progress:
        """The progress after an epoch with these metrics."""
        return Progress([*self.history, row], processes=self.processes)


def save_state(
    path: Path, modules: Mapping[str, torch.nn.Module], optimizer: Optimizer, progress: Any
) -> None:
    """Write modules, optimizer and progress.

    Args:
        path: The file.
        modules: Modules by name.
        optimizer: Optimizer of one of the modules.
        progress: Progress, JSON types.

    Raises:
        OutputError: The file cannot be written.
    """
    tensors: dict[str, Tensor] = {}
    for name, module in modules.items():
        tensors |= {f"{name}/{key}": value.clone() for key, value in module.state_dict().items()}
    for index, slots in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer/{index}/{key}": torch.as_tensor(v) for key, v in slots.items()}
    save_tensors(path, tensors, {HEADER: json.dumps(progress), VERSION: __version__})


def state_version(path: Path) -> str | None:
    """Version of the package that wrote a state; None for states without a version.

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
    """Load a state from `save_state` into the modules and the optimizer.

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
            module.load_state_dict(_with_prefix(tensors, name))
        _restore(optimizer, _with_prefix(tensors, "optimizer"))
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


def _with_prefix(tensors: Mapping[str, Tensor], name: str) -> dict[str, Tensor]:
    start = f"{name}/"
    return {key[len(start) :]: value for key, value in tensors.items() if key.startswith(start)}
