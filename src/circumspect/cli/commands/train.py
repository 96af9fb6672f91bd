"""`circumspect train`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.given_flags import given_flags
from circumspect.errors import InputError, MissingExtraError
from circumspect.training.training_changes import OF_OBJECTS, TrainingChanges

if TYPE_CHECKING:
    from circumspect.classification import InputSpec
    from circumspect.datasets import ObjectSet
    from circumspect.datasets.labelled_surfaces import LabelledSurfaces
    from circumspect.training import TrainingSettings
    from circumspect.training.sharded_training import ShardedTraining

OF_SCANS = ("catalogue", "furniture_others", "draws")
OF_CATALOGUES = ("catalogue_share", "catalogue_replicas")
NOT_OF_SHARDS = (
    "grid", "cells", "passes", "replicas", "furniture", *OF_OBJECTS, "scans", "catalogue",
    "furniture_each", "draws", "random_yaw", "validation", "validation_salt",
)  # fmt: skip
"""Flags that do not apply to shards, because `data convert` has fixed these settings."""


@dataclass(frozen=True)
class Train:
    """Train a network; the same command resumes after an interruption.

    $ circumspect train --net planes --data ModelNet10
    $ circumspect train --net moon2018 --grid rectangular --data ModelNet10
    $ circumspect train --scans --data ModelNet10 --catalogue sweethome3d.npz
    $ torchrun --nproc-per-node 2 -m circumspect train --data shards
    """

    data: Annotated[str, tyro.conf.arg(metavar="PATH|URL")]
    """Folder with train.npz, folder of ModelNet10's OFF files, folder of your own classes as
    <class>/{train,test}/* in any readable format, a set made by `gather`, or the folder or URL of
    shards made by `data convert`."""
    net: Annotated[str, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = "planes"
    """Network from `circumspect nets`, or your own NetSpec (docs/own-network.md)."""
    out: Path | None = None
    """Folder of the run, with settings, log, state and best.safetensors; runs/train-NET by
    default."""
    grid: Literal["cylindrical", "rectangular"] | None = None
    """Kind of the grid; that of the network by default."""
    cells: tuple[int, int, int] | None = None
    """Number of cells of the grid, such as 32 64 32; that of the network by default."""
    pool: Literal["rwmp", "max"] | None = None
    """moon2018 only: row-wise max pooling (rwmp), or the paper's baseline (max)."""
    changes: TrainingChanges = field(default_factory=TrainingChanges)
    """Changes of the training settings."""
    catalogue: tuple[Path, ...] = ()
    """With --scans: packs of meshes in metres, made by `circumspect data import`."""
    cache: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = field(default=None)
    """Cache folder for grids; $CIRCUMSPECT_CACHE or ~/.cache/circumspect by default."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Train, and print the accuracy."""
        try:
            from circumspect.training.draws import passes_for
            from circumspect.training.train import train
        except ImportError as error:
            raise MissingExtraError(error.name or "torch", "train") from error
        from circumspect.cli.freed_memory import keep_freed_memory
        from circumspect.cli.progress import progress_bar, speaks
        from circumspect.cli.say import say
        from circumspect.cli.training_progress import TrainingProgress
        from circumspect.datasets import GridCache, open_data_set
        from circumspect.nets.registry import net_spec, require_takes, require_turnable

        net = net_spec(pooled_net(self.net, self.pool)).name
        # Wrong flags are reported before meshes are sampled.
        settings = self._settings(net)
        shards = self._shards()
        input_spec = self._input_spec(settings) if shards is None else shards.input_spec
        require_takes(net, input_spec)
        if settings.random_yaw:
            require_turnable(net)
        catalogues = self._catalogues()
        objects: ObjectSet | ShardedTraining
        if shards is not None:
            objects = shards
        else:
            with progress_bar("sampling meshes") as progress:
                objects = open_data_set(Path(self.data), "train", progress)
            if self.changes.passes is None and (passes := passes_for(len(objects))) > 1:
                settings = replace(settings, passes=passes)
                if speaks():
                    few = f"{len(objects)} objects are few"
                    say(f"{few}: an epoch shows all {passes} times (--passes)")
        out = self.out or Path("runs") / f"train-{net}"
        keep_freed_memory()
        with TrainingProgress(settings.epochs) as observer:
            cache = GridCache(self.cache)
            checkpoint = train(
                objects, settings, out, observer, cache, input_spec, catalogues=catalogues,
                claimed=lambda: write_config(out, self, "train"),
            )  # fmt: skip
        reached = checkpoint.training["reached"]
        accuracy = reached.get("validation_accuracy")
        kept = f"epoch {reached['epoch']}" + (
            "" if accuracy is None else f", mean-class accuracy {accuracy:.4f} on validation"
        )
        if speaks():
            print(f"{out / 'best.safetensors'}: {kept}")  # noqa: T201
        return 0

    def _shards(self) -> ShardedTraining | None:
        """The sharded set; None if the set is not in shards."""
        from circumspect.datasets.sharded_set import is_sharded
        from circumspect.training.sharded_training import ShardedTraining

        if not is_sharded(self.data):
            return None
        if idle := given_flags(self, *NOT_OF_SHARDS):
            raise InputError(f"{idle[0]} goes with a set of objects; {self.data} holds shards")
        return ShardedTraining.read(self.data)

    def _catalogues(self) -> list[LabelledSurfaces]:
        if not self.changes.scans and (idle := given_flags(self, *OF_SCANS)):
            raise InputError(f"{idle[0]} goes with --scans")
        if not self.catalogue and (idle := given_flags(self, *OF_CATALOGUES)):
            raise InputError(f"{idle[0]} goes with --catalogue")
        from circumspect.datasets.catalogue import read_catalogue

        return [read_catalogue(path) for path in self.catalogue]

    def _input_spec(self, settings: TrainingSettings) -> InputSpec:
        from circumspect.classification import GridSpec
        from circumspect.training.train import input_spec_for

        net, input_spec = settings.net, input_spec_for(settings)
        if isinstance(input_spec, GridSpec):
            return replace(
                input_spec, kind=self.grid or input_spec.kind, shape=self.cells or input_spec.shape
            )
        if self.grid or self.cells:
            raise InputError(f"{net} takes points; leave out --grid and --cells")
        return input_spec

    def _settings(self, net: str) -> TrainingSettings:
        from circumspect.nets.registry import net_spec
        from circumspect.training import TrainingSettings

        changes = self.changes
        if changes.catalogue_share is None and not self.catalogue:
            changes = replace(changes, catalogue_share=0.0)
        return TrainingSettings.of_net(net_spec(net), changes)


def pooled_net(net: str, pool: str | None) -> str:
    """The name of a network with the requested pooling.

    Raises:
        InputError: The pooling of the network can not be chosen.
    """
    if pool is None:
        return net
    if net != "moon2018":
        raise InputError(f"--pool is moon2018's; {net} has no choice of pooling")
    return net if pool == "rwmp" else f"{net}-{pool}"
