"""Networks of a comparison: the shipped `modelnet10`, and networks trained for it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from circumspect.classification.shipped import MODELNET10, shipped_path
from circumspect.datasets import GridCache, ObjectSet
from circumspect.errors import InputError
from circumspect.nets.registry import NetSpec, net_spec, net_words, require_turnable
from circumspect.training import TrainingSettings
from circumspect_experiments.experiment import Experiment
from circumspect_experiments.stages import Watched, is_trained, trained
from circumspect_experiments.training_record import training_record
from circumspect_experiments.whole_set import require_shipped_classes

OURS = "circumspect"
"""The shipped classifier `modelnet10`, with the paper's protocol."""
RIVALS = ("moon2018", "voxnet", "3dshapenets", "deeppano", "mvcnn", "pointnet", "voxelnet")
"""Networks that are trained at 0° alone."""
ALL_ROWS = (
    "moon2018", "voxnet", "voxnet-random-yaw", "3dshapenets", "3dshapenets-random-yaw", "deeppano",
    "mvcnn", "pointnet", "pointnet-random-yaw", "pointmlp", "pointmlp-random-yaw", "voxelnet",
)  # fmt: skip
SUFFIX = "-random-yaw"
"""Suffix of rows that are trained at random yaw."""


@dataclass(frozen=True)
class Contender:
    """A network that is trained at 0° alone, or at random yaw.

    Attributes:
        net: Name of the network.
        random_yaw: Training objects are turned about the vertical at random.
    """

    net: str
    random_yaw: bool = False

    @classmethod
    def from_name(cls, name: str) -> Contender:
        """Read the name of a row: NET, or NET-random-yaw.

        Raises:
            InputError: No network of that name, or it can not be trained at random yaw.
        """
        net = name.removesuffix(SUFFIX)
        random_yaw = net != name
        if random_yaw:
            require_turnable(net)
        return cls(net_spec(net).name, random_yaw)

    @property
    def words(self) -> str:
        """Its name on the command line, or MODULE:NAME of a network that is not installed."""
        return net_words(self.net) + (SUFFIX if self.random_yaw else "")

    @property
    def name(self) -> str:
        """Its name in files and of its folder."""
        return f"{self.net}{SUFFIX}" if self.random_yaw else self.net

    @property
    def label(self) -> str:
        """Its name in tables and pictures."""
        return f"{self.net}, trained at random yaw" if self.random_yaw else self.net

    @property
    def spec(self) -> NetSpec:
        """The network."""
        return net_spec(self.net)

    @property
    def settings(self) -> TrainingSettings:
        """Its training settings; at random yaw with at least the usual number of variants."""
        defaults = TrainingSettings.of_net(self.spec)
        if not self.random_yaw:
            return defaults
        replicas = max(defaults.replicas, TrainingSettings.replicas)
        return replace(defaults, random_yaw=True, replicas=replicas)


@dataclass(frozen=True, kw_only=True)
class Comparison(Experiment):
    """Settings of a comparison; see `Experiment`.

    Attributes:
        nets: Rows beside the shipped classifier, by the names of `Contender`.
        only: Rows to train and measure now; none means all. Other rows are included if they are
            finished.

    Raises:
        InputError: See `Experiment`; or a row is no network, or `only` names a row that is not
            compared.
    """

    nets: tuple[str, ...] = ALL_ROWS
    only: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        # MODULE:NAME is replaced by the name of the network, also used for its row and its folder.
        object.__setattr__(self, "nets", tuple(Contender.from_name(n).name for n in self.nets))
        only = (Contender.from_name(name).name if ":" in name else name for name in self.only)
        object.__setattr__(self, "only", tuple(only))
        super().__post_init__()
        rows = (OURS, *self.nets)
        if unknown := [name for name in self.only if name not in rows]:
            raise InputError(f"--only {unknown[0]}: this comparison has {', '.join(rows)}")

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`."""
        return self.nets

    def default_settings(self, net: str) -> TrainingSettings:
        """See `Experiment.default_settings`."""
        return Contender.from_name(net).settings

    def asks_for(self, row: str) -> bool:
        """Whether a row is trained and measured now."""
        return not self.only or row in self.only

    def of_rows(self, rows: Iterable[str]) -> Comparison:
        """The comparison restricted to these rows, beside the shipped classifier."""
        nets = tuple(name for name in self.nets if name in set(rows))
        return replace(
            self,
            nets=nets,
            only=(),
            epochs_of={net: value for net, value in self.epochs_of.items() if net in nets},
            precision_of={net: value for net, value in self.precision_of.items() if net in nets},
        )

    def command(self, what: str) -> str:
        """See `Experiment.command`."""
        words = [Contender.from_name(name).words for name in self.nets]
        some = [] if self.nets == ALL_ROWS else ["--nets", *words]
        if not self.nets:
            # `--nets` without names would mean all of them.
            some = ["--only", OURS]
        return super().command(" ".join([what, *some]))


def label_of(row: str) -> str:
    """A row's name in tables and pictures."""
    return row if row == OURS else Contender.from_name(row).label


def trained_contenders(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> tuple[dict[str, Path], dict[str, dict[str, Any]]]:
    """Train the missing networks; experiments in the same folder share trained networks.

    A row that is not requested is left out unless its training is finished.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split, with the classes of `modelnet10`.
        how: Settings.
        folder: A run of each network goes to `NET/training`.
        watched: Receives the progress.
        cache: Cache for grids.

    Returns:
        Weights by name, the shipped classifier first, and records of the trainings.

    Raises:
        WeightsError: The classifier `modelnet10` has other classes than the set.
        InputError: The set lacks classes of ModelNet10, or has others; or the folder holds results
            of another experiment.
        OutputError: It can not be written.
    """
    require_shipped_classes(train, test)
    weights, records = {OURS: shipped_path(MODELNET10)}, {}
    for net in how.nets:
        settings, input_spec = how.settings(net), Contender.from_name(net).spec.input_spec
        at = folder / net / "training"
        if not how.asks_for(net) and not is_trained(train, settings, input_spec, at):
            continue
        with watched.training(net, settings.epochs) as observer:
            weights[net] = trained(train, settings, input_spec, at, observer, cache)
        records[net] = training_record(weights[net])
    return weights, records
