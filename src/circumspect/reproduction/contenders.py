"""The networks that are compared: `modelnet10`, which ships, and those that are trained for it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from circumspect.classification.shipped import MODELNET10, shipped_path
from circumspect.datasets import GridCache, ObjectSet
from circumspect.errors import InputError
from circumspect.evaluation.predictor import check_classes, load_predictor
from circumspect.reproduction.contender import Contender
from circumspect.reproduction.experiment import Experiment
from circumspect.reproduction.stages import is_trained, trained
from circumspect.reproduction.training_record import training_record
from circumspect.reproduction.watched import Watched
from circumspect.reproduction.whole_set import require_modelnet10
from circumspect.training import TrainingSettings

OURS = "circumspect"
"""The shipped classifier `modelnet10`: the paper's protocol."""
RIVALS = ("moon2018", "voxnet", "3dshapenets", "deeppano", "mvcnn", "pointnet", "voxelnet")
"""Trained at 0° alone."""
ALL_ROWS = (
    "moon2018", "voxnet", "voxnet-random-yaw", "3dshapenets", "3dshapenets-random-yaw", "deeppano",
    "mvcnn", "pointnet", "pointnet-random-yaw", "pointmlp", "pointmlp-random-yaw", "voxelnet",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Comparison(Experiment):
    """How networks are compared; see `Experiment`.

    Attributes:
        nets: Rows beside ours, by the names of `Contender`.
        only: Rows that are trained and measured now; none means all. Of the others those are shown
            that are finished.

    Raises:
        InputError: As `Experiment`; or no network of a row's name, or `only` names a row that is
            not compared.
    """

    nets: tuple[str, ...] = ALL_ROWS
    only: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        # MODULE:NAME becomes the network's own name, which is that of its row and its folder.
        object.__setattr__(self, "nets", tuple(Contender.from_name(n).name for n in self.nets))
        only = (Contender.from_name(name).name if ":" in name else name for name in self.only)
        object.__setattr__(self, "only", tuple(only))
        super().__post_init__()
        rows = (OURS, *self.nets)
        if strange := [name for name in self.only if name not in rows]:
            raise InputError(f"--only {strange[0]}: this comparison has {', '.join(rows)}")

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`."""
        return self.nets

    def meant(self, net: str) -> TrainingSettings:
        """See `Experiment.meant`."""
        return Contender.from_name(net).settings

    def asks_for(self, row: str) -> bool:
        """Whether a row is to be trained and measured now."""
        return not self.only or row in self.only

    def of_rows(self, rows: Iterable[str]) -> Comparison:
        """The comparison of these rows and no others beside ours."""
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
            # `--nets` without names would be all of them.
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
    """Train what is not trained yet; experiments in one folder share the trainings.

    A row that is not asked for is left out unless its training is finished.

    Args:
        train: ModelNet10's training split; part of it is held back to choose the best epoch.
        test: Its test split, which `modelnet10` must know.
        how: Settings.
        folder: A run of each network goes to `NET/training`.
        watched: Told of the progress.
        cache: Where grids are kept.

    Returns:
        Weights by name, ours first, and records of the trainings.

    Raises:
        WeightsError: The classifier `modelnet10` knows other classes than the set.
        InputError: The set lacks classes of ModelNet10, or has others; or the folder holds results
            of another experiment.
        OutputError: It can not be written.
    """
    require_modelnet10(train, test)
    check_classes(load_predictor(MODELNET10), test)
    weights, records = {OURS: shipped_path(MODELNET10)}, {}
    for net in how.nets:
        settings, recipe = how.settings(net), Contender.from_name(net).spec.recipe
        at = folder / net / "training"
        if not how.asks_for(net) and not is_trained(train, settings, recipe, at):
            continue
        with watched.training(net, settings.epochs) as observer:
            weights[net] = trained(train, settings, recipe, at, observer, cache)
        records[net] = training_record(weights[net])
    return weights, records
