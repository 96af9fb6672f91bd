"""The networks that are compared: `modelnet10`, which ships, and those that are trained for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from circumspect.classification.shipped import MODELNET10, shipped_path
from circumspect.datasets import GridCache, ObjectSet
from circumspect.evaluation.predictor import check_classes, load_predictor
from circumspect.nets.registry import net_spec
from circumspect.reproduction.experiment import Experiment
from circumspect.reproduction.stages import trained
from circumspect.reproduction.training_record import training_record
from circumspect.reproduction.watched import Watched
from circumspect.reproduction.whole_set import require_modelnet10

OURS = "circumspect"
"""The shipped classifier `modelnet10`: the paper's protocol."""
RIVALS = ("moon2018", "voxnet", "3dshapenets", "deeppano", "mvcnn", "pointnet", "voxelnet")


@dataclass(frozen=True, kw_only=True)
class Comparison(Experiment):
    """How networks are compared; see `Experiment`.

    Attributes:
        nets: Beside ours.
    """

    nets: tuple[str, ...] = RIVALS

    @property
    def trained_nets(self) -> tuple[str, ...]:
        """See `Experiment.trained_nets`."""
        return self.nets

    def command(self, what: str) -> str:
        """See `Experiment.command`."""
        some = [] if self.nets == RIVALS else ["--nets", *self.nets]
        return super().command(" ".join([what, *some]))


def trained_contenders(
    train: ObjectSet,
    test: ObjectSet,
    how: Comparison,
    folder: Path,
    watched: Watched,
    cache: GridCache | None = None,
) -> tuple[dict[str, Path], dict[str, dict[str, Any]]]:
    """Train what is not trained yet; experiments in one folder share the trainings.

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
        settings = how.settings(net)
        with watched.training(net, settings.epochs) as observer:
            at = folder / net / "training"
            weights[net] = trained(train, settings, net_spec(net).recipe, at, observer, cache)
        records[net] = training_record(weights[net])
    return weights, records
