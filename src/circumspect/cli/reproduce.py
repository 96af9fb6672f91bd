"""`circumspect reproduce`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import tyro

from circumspect.cli.freed_memory import keep_freed_memory
from circumspect.cli.given_flags import given_flags
from circumspect.cli.progress import progress_bar
from circumspect.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from collections.abc import Callable

    from circumspect.training.train import TrainingObserver


COMPARISONS = ("rivals", "robustness")
MEANT = {
    "epochs": "a number of epochs; try 24 or moon2018=6",
    "precision": "a precision; try bf16 or moon2018=fp32",
}
T = TypeVar("T")


@dataclass(frozen=True)
class Reproduce:
    """The paper's Table 2, or a comparison beyond it; the same command goes on.

    $ circumspect reproduce table2 --data ModelNet10 --out table2
    $ circumspect reproduce table2 --data ModelNet10 --robot gathered
    $ circumspect reproduce rivals --data ModelNet10 --epochs 24 moon2018=6
    $ circumspect reproduce robustness --data ModelNet10 --epochs 24 moon2018=6
    $ circumspect reproduce rivals --data ModelNet10 --nets voxnet pointnet
    $ circumspect reproduce rivals --data ModelNet10 --only pointmlp
    $ circumspect reproduce unknown --data ModelNet10 --yaw-count 8
    $ circumspect reproduce real --crops objects.npz --contenders own=own.onnx
    $ circumspect reproduce real --crops objects.npz --nets voxnet --data ModelNet10
    """

    what: tyro.conf.Positional[Literal["table2", "rivals", "robustness", "unknown", "real"]]
    """table2: the paper's network on both grids, with both poolings; rivals: it, seven others and
    ours, at all yaws and any way up, four of them trained at random yaw as well; robustness: the
    paper's, six others and ours on corrupted objects; unknown: ours without each class in turn;
    real: classifiers on labelled real objects."""
    data: Path | None = None
    """Folder with point packs, or ModelNet10's folder of OFF files. Required, but for real."""
    crops: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE")] = ()
    """Of real: files of labelled real objects."""
    contenders: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=FILE")] = ()
    """Of real: ONNX classifiers, checkpoints or folders of runs, beside the shipped classifier."""
    catalogue: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE")] = ()
    """Of real with --nets: packs of meshes in metres to train on beside --data."""
    scale: Literal["metric", "unknown"] = "metric"
    """Of real: unknown withholds from the classifiers that coordinates are metres."""
    robot: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Of table2: a set that `circumspect gather` made; the table's other half, on scans."""
    out: Path | None = None
    """Folder for runs, tables and figures; runs/WHAT by default, and of robustness runs/rivals,
    whose trainings it shares."""
    nets: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NET")] = ()
    """Of rivals and robustness: these rows beside ours, NET or NET-random-yaw for one that is
    trained on objects turned at random about the vertical; without it those of WHAT. Of real:
    networks to train on simulated scans of --data, none without it."""
    only: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NET")] = ()
    """Of rivals and robustness: train and measure these rows now (circumspect is ours); the table
    holds them and every other row that is finished."""
    epochs: Annotated[tuple[str, ...], tyro.conf.arg(metavar="INT|NET=INT")] = ()
    """Of every row, of one by its name, or both; without it those that each is meant for."""
    yaw_count: int = 64
    """Yaws over the turn, each at another fraction of a cell."""
    precision: Annotated[tuple[str, ...], tyro.conf.arg(metavar="fp32|bf16|NET=…")] = ()
    """Of every row, of one by its name, or both; fp32 by default. bf16 is automatic mixed
    precision, for CPUs and GPUs that have it."""
    seed: int = 0
    """Of all chance."""
    json: bool = False
    """Print the table as JSON and nothing else on standard output."""
    cache: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = field(default=None)
    """Where grids are kept; $CIRCUMSPECT_CACHE or ~/.cache/circumspect by default."""

    def run(self) -> int:
        """Do what is not yet done, and print the table."""
        if self.what == "real":
            return self._real_objects()
        if misplaced := given_flags(self, "crops", "contenders", "catalogue", "scale"):
            raise InputError(f"{misplaced[0]} goes with real")
        if self.data is None:
            raise InputError(f"{self.what} needs --data: ModelNet10's folder, or point packs")
        if self.robot is not None and self.what != "table2":
            raise InputError("--robot goes with table2")
        for flag in ("nets", "only"):
            if getattr(self, flag) and self.what not in COMPARISONS:
                raise InputError(f"--{flag} goes with {' and '.join(COMPARISONS)}")
        try:
            from circumspect import reproduction as experiments
        except ImportError as error:
            raise MissingExtraError(error.name or "torch", "train") from error
        from circumspect.datasets import GridCache, open_data_set

        kinds: dict[str, tuple[Callable[..., Any], Callable[..., dict[str, Any]]]] = {
            "table2": (experiments.Table2, experiments.reproduce_table2),
            "rivals": (experiments.Comparison, experiments.reproduce_rivals),
            "robustness": (experiments.Comparison, experiments.reproduce_robustness),
            "unknown": (experiments.Unknown, experiments.reproduce_unknown),
        }
        kind, reproduce = kinds[self.what]
        # What is wrong with the flags or with the robot's set is told before hours of training.
        how = kind(**self._flags())
        scans = None if self.robot is None else experiments.RobotScans.read(self.robot)
        shared = "rivals" if self.what == "robustness" else self.what
        out = self.out or Path("runs") / shared
        with progress_bar("sampling meshes") as progress:
            train, test = (open_data_set(self.data, split, progress) for split in ("train", "test"))
        if train.classes != test.classes:
            raise InputError(
                f"{self.data}: what is trained on has the classes {', '.join(train.classes)}, the "
                f"test split {', '.join(test.classes)}"
            )
        if both := set(train.names.tolist()) & set(test.names.tolist()):
            raise InputError(
                f"{self.data}: {len(both)} objects are in both splits, as {min(both)} is; what was "
                "trained on is no test"
            )
        rest = (out, Shown(), GridCache(self.cache))
        keep_freed_memory()
        document = reproduce(train, test, how, *rest)
        self._show(out / f"{self.what}.md")
        if scans is not None:
            document["robot"] = experiments.reproduce_robot(scans, how, *rest)
            self._show(out / "table2_robot.md")
        if self.json:
            print(json.dumps(document))  # noqa: T201
        return 0

    def _real_objects(self) -> int:
        """Compare classifiers on real objects."""
        if misplaced := given_flags(self, "robot", "yaw_count", "only"):
            raise InputError(f"{misplaced[0]} does not go with real")
        if self.nets and self.data is None:
            raise InputError("--nets of real needs --data, the CAD data to train on")
        if not self.crops:
            raise InputError("real needs --crops: files of labelled real objects")
        try:
            from circumspect import reproduction as experiments
        except ImportError as error:
            raise MissingExtraError(error.name or "torch", "train") from error
        from circumspect.datasets import GridCache
        from circumspect.reproduction.real import named_contenders

        how = experiments.RealObjects(
            **self._flags(), contenders=named_contenders(self.contenders),
            scale=self.scale, data=self.data, catalogues=self.catalogue,
        )  # fmt: skip
        out = self.out or Path("runs") / self.what
        cache = GridCache(self.cache)
        document = experiments.reproduce_real(self.crops, how, out, Shown(), cache)
        self._show(out / f"{self.what}.md")
        if self.json:
            print(json.dumps(document))  # noqa: T201
        return 0

    def _flags(self) -> dict[str, Any]:
        """What the experiment is made of."""
        from circumspect.reproduction.contenders import RIVALS

        flags: dict[str, Any] = {"yaw_count": self.yaw_count, "seed": self.seed}
        flags["epochs"], flags["epochs_of"] = _of_networks("epochs", self.epochs, _epochs)
        every, flags["precision_of"] = _of_networks("precision", self.precision, _precision)
        flags["precision"] = every or "fp32"
        # Twice the same name is the same row.
        nets = tuple(dict.fromkeys(self.nets))
        if self.what == "real":
            flags["nets"] = nets
        elif self.what in COMPARISONS:
            flags["only"] = self.only
            if nets:
                flags["nets"] = nets
            elif self.what == "robustness":
                flags["nets"] = RIVALS
        return flags

    def _show(self, table: Path) -> None:
        """Print a table as soon as it is there: the next may be hours away."""
        if not self.json:
            print(table.read_text(encoding="utf-8"), flush=True)  # noqa: T201


def _of_networks(
    flag: str, words: tuple[str, ...], read: Callable[[str], T | None]
) -> tuple[T | None, dict[str, T]]:
    """What a flag says of every row, and of single ones."""
    from circumspect.reproduction.contender import Contender

    every, single = None, {}
    for word in words:
        net, equals, text = word.rpartition("=")
        value = read(text)
        if value is None:
            raise InputError(f"--{flag} {word}: not {MEANT[flag]}")
        if equals:
            single[Contender.from_name(net).name] = value
        else:
            every = value
    return every, single


def _epochs(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and int(text) > 0 else None


def _precision(text: str) -> str | None:
    return text if text in ("fp32", "bf16") else None


class Shown:
    """Shows an experiment's progress; a `Watched`."""

    @contextmanager
    def training(self, name: str, epochs: int) -> Iterator[TrainingObserver]:
        """Bars, and a line an epoch."""
        from circumspect.cli.training_progress import TrainingProgress

        _say(f"{name}: training")
        with TrainingProgress(epochs) as observer:
            yield observer

    def measuring(
        self, name: str, counted: str = "objects"
    ) -> AbstractContextManager[Callable[[int, int], None]]:
        """A bar."""
        _say(f"{name}: measuring")
        return progress_bar(counted)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201
