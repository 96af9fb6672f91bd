"""Settings that all experiments share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from circumspect.errors import InputError
from circumspect.evaluation.yaw_sweep import MAX_YAWS
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings

Precision = Literal["fp32", "bf16"]


@dataclass(frozen=True, kw_only=True)
class Experiment(ABC):
    """Settings of an experiment.

    Attributes:
        epochs: Epochs of every network; None means its default.
        epochs_of: Epochs of single networks, by name; takes precedence.
        yaw_count: Number of yaws over a full turn, each at another fraction of a cell.
        precision: "fp32" or "bf16".
        precision_of: Precision of single networks, by name; takes precedence.
        seed: Random seed.

    Raises:
        InputError: Epochs or precision of a network that is not trained, or no yaws.
    """

    epochs: int | None = None
    epochs_of: Mapping[str, int] = field(default_factory=dict)
    yaw_count: int = 64
    precision: Precision = "fp32"
    precision_of: Mapping[str, Precision] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        if not 1 <= self.yaw_count <= MAX_YAWS:
            raise InputError(f"--yaw-count must be 1 to {MAX_YAWS}, not {self.yaw_count}")
        for flag, single in (("epochs", self.epochs_of), ("precision", self.precision_of)):
            if untrained := set(single) - set(self.trained_nets):
                raise InputError(
                    f"--{flag} {min(untrained)}=…: this experiment trains "
                    f"{', '.join(self.trained_nets)}"
                )

    @property
    @abstractmethod
    def trained_nets(self) -> tuple[str, ...]:
        """Names of the networks that are trained."""

    def settings(self, net: str) -> TrainingSettings:
        """A network's default training settings, with the changes of the experiment."""
        defaults = self.default_settings(net)
        epochs = self.epochs_of.get(net) or self.epochs or defaults.epochs
        precision = self.precision_of.get(net, self.precision)
        return replace(defaults, epochs=epochs, precision=precision, seed=self.seed)

    def default_settings(self, net: str) -> TrainingSettings:
        """A network's default training settings."""
        return TrainingSettings.of_net(net_spec(net))

    @property
    def precisions(self) -> str:
        """The values of `--precision`: "bf16 moon2018=fp32"."""
        return " ".join(_words(self.precision, self.precision_of))

    def command(self, what: str) -> str:
        """The command that repeats the experiment.

        Args:
            what: Words of the command after `circumspect reproduce`.
        """
        yaws = ["--yaw-count", str(self.yaw_count)]
        words = [what, *self._epoch_flag(), *yaws, *self._other_flags()]
        return f"circumspect reproduce {' '.join(words)}"

    def training_flags(self) -> list[str]:
        """The flags that determine trainings."""
        return [*self._epoch_flag(), *self._other_flags()]

    def _epoch_flag(self) -> list[str]:
        epochs = _words(self.epochs, self.epochs_of)
        return ["--epochs", *epochs] if epochs else []

    def _other_flags(self) -> list[str]:
        return ["--precision", *self.precisions.split(), "--seed", str(self.seed)]


def _words(every: Any, single: Mapping[str, Any]) -> list[str]:
    """The words of a flag: the value for all networks, if any, and those of single networks."""
    return [
        *([] if every is None else [str(every)]),
        *(f"{net}={value}" for net, value in single.items()),
    ]
