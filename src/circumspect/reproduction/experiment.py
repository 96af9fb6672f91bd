"""What all experiments can be asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from circumspect.errors import InputError
from circumspect.evaluation.yaw_sweep import MOST_YAWS
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings

Precision = Literal["fp32", "bf16"]


@dataclass(frozen=True, kw_only=True)
class Experiment(ABC):
    """How an experiment is done.

    Attributes:
        epochs: Of every network; None means those it is meant for.
        epochs_of: Of single networks, by name, in their place.
        yaw_count: Yaws over the turn, each at another fraction of a cell.
        precision: "fp32" or "bf16".
        precision_of: Of single networks, by name, in its place.
        seed: Of all chance.

    Raises:
        InputError: Epochs or precision of a network that it does not train, or no yaws.
    """

    epochs: int | None = None
    epochs_of: Mapping[str, int] = field(default_factory=dict)
    yaw_count: int = 64
    precision: Precision = "fp32"
    precision_of: Mapping[str, Precision] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        if not 1 <= self.yaw_count <= MOST_YAWS:
            raise InputError(f"--yaw-count must be 1 to {MOST_YAWS}, not {self.yaw_count}")
        for flag, single in (("epochs", self.epochs_of), ("precision", self.precision_of)):
            if strange := set(single) - set(self.trained_nets):
                raise InputError(
                    f"--{flag} {min(strange)}=…: this experiment trains "
                    f"{', '.join(self.trained_nets)}"
                )

    @property
    @abstractmethod
    def trained_nets(self) -> tuple[str, ...]:
        """Names of the networks that it trains."""

    def settings(self, net: str) -> TrainingSettings:
        """As a network is meant to be trained, but for what the experiment asks for."""
        meant = self.meant(net)
        epochs = self.epochs_of.get(net) or self.epochs or meant.epochs
        precision = self.precision_of.get(net, self.precision)
        return replace(meant, epochs=epochs, precision=precision, seed=self.seed)

    def meant(self, net: str) -> TrainingSettings:
        """As a network is meant to be trained."""
        return TrainingSettings.of_net(net_spec(net))

    @property
    def precisions(self) -> str:
        """As the command tells them: "bf16 moon2018=fp32"."""
        return " ".join(_words(self.precision, self.precision_of))

    def command(self, what: str) -> str:
        """What does the same again.

        Args:
            what: The command's words after `circumspect reproduce`.
        """
        yaws = ["--yaw-count", str(self.yaw_count)]
        words = [what, *self._epoch_flag(), *yaws, *self._other_flags()]
        return f"circumspect reproduce {' '.join(words)}"

    def training_flags(self) -> list[str]:
        """The words of the flags that determine trainings."""
        return [*self._epoch_flag(), *self._other_flags()]

    def _epoch_flag(self) -> list[str]:
        epochs = _words(self.epochs, self.epochs_of)
        return ["--epochs", *epochs] if epochs else []

    def _other_flags(self) -> list[str]:
        return ["--precision", *self.precisions.split(), "--seed", str(self.seed)]


def _words(every: Any, single: Mapping[str, Any]) -> list[str]:
    """A flag's words: what holds for every network, if anything, and for single ones."""
    return [
        *([] if every is None else [str(every)]),
        *(f"{net}={value}" for net, value in single.items()),
    ]
