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

from circumspect.cli.config_file import CONFIG, ConfigFlag, write_config
from circumspect.cli.freed_memory import keep_freed_memory
from circumspect.cli.given_flags import given_flags
from circumspect.cli.progress import progress_bar
from circumspect.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

    from circumspect.training.train import TrainingObserver


COMPARISONS = ("rivals", "robustness")
MEANT = {
    "epochs": "a number of epochs; try 24 or moon2018=6",
    "precision": "a precision; try bf16 or moon2018=fp32",
}
T = TypeVar("T")


@dataclass(frozen=True)
class Reproduce:
    """Reproduce the paper's Table 2, or run a further comparison.

    $ circumspect reproduce table2 --data ModelNet10 --out table2
    $ circumspect reproduce table2 --data ModelNet10 --robot gathered
    $ circumspect reproduce rivals --data ModelNet10 --epochs 24 moon2018=6
    $ circumspect reproduce robustness --data ModelNet10 --epochs 24 moon2018=6
    $ circumspect reproduce rivals --data ModelNet10 --nets voxnet pointnet
    $ circumspect reproduce rivals --data ModelNet10 --only pointmlp
    $ circumspect reproduce unknown --data ModelNet10 --yaw-count 8
    $ circumspect reproduce real --crops objects.npz --contenders own=own.onnx
    $ circumspect reproduce real --crops objects.npz --nets voxnet --data ModelNet10

    The same command resumes after an interruption.
    """

    what: tyro.conf.Positional[Literal["table2", "rivals", "robustness", "unknown", "real"]]
    """table2: the paper's network on both grids, with both poolings. rivals: this network, seven
    others and the shipped classifier, at all yaws and in any pose; four of them also trained at
    random yaw. robustness: the paper's network, six others and the shipped classifier on corrupted
    objects. unknown: the network planes, trained without each class in turn. real: classifiers on
    labelled real objects."""
    data: Path | None = None
    """Folder with point packs, or folder of ModelNet10's OFF files. Required, except for real."""
    crops: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE")] = ()
    """real only: files of labelled real objects."""
    contenders: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=FILE")] = ()
    """real only: ONNX files, checkpoints or folders of runs to compare with the shipped
    classifier."""
    catalogue: Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE")] = ()
    """real with --nets: packs of meshes in metres to train on, in addition to --data."""
    scale: Literal["metric", "unknown"] = "metric"
    """real only: unknown hides from the classifiers that coordinates are in metres."""
    robot: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """table2 only: set made by `circumspect gather`, for the half of the table on scans."""
    out: Path | None = None
    """Folder for runs, tables and figures; runs/WHAT by default. robustness uses runs/rivals,
    because it shares the trained networks."""
    nets: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NET")] = ()
    """rivals and robustness: networks to compare with the shipped classifier. NET-random-yaw is
    NET trained on objects turned at random about the vertical. By default those of WHAT. real:
    networks to train on simulated scans of --data; none by default."""
    only: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NET")] = ()
    """rivals and robustness only: rows to train and measure now; circumspect is the shipped
    classifier. The table also contains all other finished rows."""
    epochs: Annotated[tuple[str, ...], tyro.conf.arg(metavar="INT|NET=INT")] = ()
    """Number of epochs of all rows, of single rows by name, or both; that of each network by
    default."""
    yaw_count: int = 64
    """Number of yaws over a full turn, each at another fraction of a cell."""
    precision: Annotated[tuple[str, ...], tyro.conf.arg(metavar="fp32|bf16|NET=…")] = ()
    """Precision of all rows, of single rows by name, or both; fp32 by default. bf16 is automatic
    mixed precision, for CPUs and GPUs that support it."""
    seed: int = 0
    """Random seed."""
    json: bool = False
    """Print the table as JSON on standard output and nothing else."""
    cache: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = field(default=None)
    """Cache folder for grids; $CIRCUMSPECT_CACHE or ~/.cache/circumspect by default."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Run the missing stages, and print the table."""
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
        experiments = _experiments()
        from circumspect.datasets import GridCache, open_data_set

        kinds: dict[str, tuple[Callable[..., Any], Callable[..., dict[str, Any]]]] = {
            "table2": (experiments.Table2, experiments.reproduce_table2),
            "rivals": (experiments.Comparison, experiments.reproduce_rivals),
            "robustness": (experiments.Comparison, experiments.reproduce_robustness),
            "unknown": (experiments.Unknown, experiments.reproduce_unknown),
        }
        kind, reproduce = kinds[self.what]
        # Errors in the flags or in the robot's set are reported before hours of training.
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
        with self._recorded(out):
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
        experiments = _experiments()
        from circumspect.datasets import GridCache
        from circumspect_experiments.real import named_contenders

        how = experiments.RealObjects(
            **self._flags(), contenders=named_contenders(self.contenders),
            scale=self.scale, data=self.data, catalogues=self.catalogue,
        )  # fmt: skip
        out = self.out or Path("runs") / self.what
        cache = GridCache(self.cache)
        with self._recorded(out):
            document = experiments.reproduce_real(self.crops, how, out, Shown(), cache)
        self._show(out / f"{self.what}.md")
        if self.json:
            print(json.dumps(document))  # noqa: T201
        return 0

    @contextmanager
    def _recorded(self, out: Path) -> Iterator[None]:
        """Write the flags after the experiment; after an interruption only if there are none."""
        try:
            yield
        except KeyboardInterrupt:
            if out.exists() and not (out / CONFIG).exists():
                write_config(out, self, "reproduce")
            raise
        write_config(out, self, "reproduce")

    def _flags(self) -> dict[str, Any]:
        """The settings of the experiment."""
        from circumspect_experiments.contenders import RIVALS

        flags: dict[str, Any] = {"yaw_count": self.yaw_count, "seed": self.seed}
        flags["epochs"], flags["epochs_of"] = _per_network("epochs", self.epochs, _epochs)
        every, flags["precision_of"] = _per_network("precision", self.precision, _precision)
        flags["precision"] = every or "fp32"
        # Repeated names are the same row.
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
        """Print a table at once; the next one may take hours."""
        if not self.json:
            from circumspect.cli.report_screen import print_report

            print_report(table.read_text(encoding="utf-8"))


def _experiments() -> ModuleType:
    """Import the package of the experiments, which needs torch.

    Raises:
        MissingExtraError: torch or another package of the extra is not installed.
    """
    try:
        import circumspect_experiments.stages as _  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(error.name or "torch", "train") from error
    return sys.modules["circumspect_experiments"]


def _per_network(
    flag: str, words: tuple[str, ...], read: Callable[[str], T | None]
) -> tuple[T | None, dict[str, T]]:
    """The value of a flag for all rows, and those for single rows."""
    from circumspect_experiments.contenders import Contender

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
        """Show bars, and one line per epoch."""
        from circumspect.cli.training_progress import TrainingProgress

        _say(f"{name}: training")
        with TrainingProgress(epochs) as observer:
            yield observer

    def measuring(
        self, name: str, counted: str = "objects"
    ) -> AbstractContextManager[Callable[[int, int], None]]:
        """Show a bar."""
        _say(f"{name}: measuring")
        return progress_bar(counted)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201
