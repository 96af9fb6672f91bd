"""What all experiments can be asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from circumspect.errors import InputError
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings


@dataclass(frozen=True, kw_only=True)
class Experiment(ABC):
    """How an experiment is done.

    Attributes:
        epochs: Of every network; None means those it is meant for.
        epochs_of: Of single networks, by name, in their place.
        yaw_count: Yaws over the turn, each at another fraction of a cell.
        precision: "fp32" or "bf16".
        seed: Of all chance.

    Raises:
        InputError: Epochs of a network that it does not train.
    """

    epochs: int | None = None
    epochs_of: Mapping[str, int] = field(default_factory=dict)
    yaw_count: int = 64
    precision: Literal["fp32", "bf16"] = "fp32"
    seed: int = 0

    def __post_init__(self) -> None:
        if strange := set(self.epochs_of) - set(self.trained_nets):
            raise InputError(
                f"--epochs {min(strange)}=…: this experiment trains {', '.join(self.trained_nets)}"
            )

    @property
    @abstractmethod
    def trained_nets(self) -> tuple[str, ...]:
        """Names of the networks that it trains."""

    def settings(self, net: str) -> TrainingSettings:
        """As a network is meant to be trained, but for what the experiment asks for."""
        meant = TrainingSettings(**{**net_spec(net).training, "net": net})
        epochs = self.epochs_of.get(net) or self.epochs or meant.epochs
        return replace(meant, epochs=epochs, precision=self.precision, seed=self.seed)

    def command(self, what: str) -> str:
        """What does the same again.

        Args:
            what: The command's words after `circumspect reproduce`.
        """
        epochs = [] if self.epochs is None else [str(self.epochs)]
        epochs += [f"{net}={count}" for net, count in self.epochs_of.items()]
        if epochs:
            epochs.insert(0, "--epochs")
        words = [what, *epochs, "--yaw-count", str(self.yaw_count), "--precision", self.precision]
        return f"circumspect reproduce {' '.join([*words, '--seed', str(self.seed)])}"
