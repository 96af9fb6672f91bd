"""`circumspect train`."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from circumspect.cli.given_flags import given_flags
from circumspect.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from circumspect.classification import InputRecipe
    from circumspect.datasets import ObjectSet
    from circumspect.datasets.labelled_surfaces import LabelledSurfaces
    from circumspect.training import TrainingSettings
    from circumspect.training.sharded_training import ShardedTraining

CHANGES = ("stretch", "partial", "damage")
"""Flags on how objects are changed at random."""
OF_SCANS = ("catalogue", "furniture_others", "draws")
OF_CATALOGUES = ("catalogue_share", "catalogue_replicas")
OF_OBJECTS = (
    "grid", "cells", "passes", "replicas", "furniture", *CHANGES, "scans", "catalogue",
    "furniture_each", "draws", "random_yaw", "validation", "validation_salt",
)  # fmt: skip
"""Flags on what `data convert` decided where the set is in shards."""


@dataclass(frozen=True)
class Train:
    """Train a network; the same command goes on after an interruption.

    $ circumspect train --net planes --data ModelNet10
    $ circumspect train --net moon2018 --grid rectangular --data ModelNet10
    $ circumspect train --scans --data ModelNet10 --catalogue sweethome3d.npz
    $ torchrun --nproc-per-node 2 -m circumspect train --data shards
    """

    data: Annotated[str, tyro.conf.arg(metavar="PATH|URL")]
    """Folder with train.npz, ModelNet10's folder of OFF files, one of own classes as
    <class>/{train,test}/* in any readable format, a set that `gather` made, or the folder or URL of
    shards that `data convert` made."""
    net: Annotated[str, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = "planes"
    """One of `circumspect nets`, or a NetSpec of your own: docs/own-network.md."""
    out: Path | None = None
    """Folder of the run: settings, log, state, best.safetensors; runs/train-NET by default."""
    grid: Literal["cylindrical", "rectangular"] | None = None
    """Kind of the grid; without it the one the network is meant for."""
    cells: tuple[int, int, int] | None = None
    """Of the grid, such as 32 64 32; without it those the network is meant for."""
    pool: Literal["rwmp", "max"] | None = None
    """Of moon2018: row-wise max pooling, or the paper's comparison with it."""
    epochs: int | None = None
    """How many; after each the held-back objects are named, and progress is saved."""
    passes: int | None = None
    """How often an epoch goes through the set; without it once, and through a small set as often as
    makes about 500 objects."""
    batch_size: int | None = None
    """Objects a step."""
    learning_rate: float | None = None
    """Its peak."""
    mixing: float | None = None
    """Share of the batches in which each object is blended with another (mixup), 0 … 1."""
    balance: float | None = None
    """1 draws all classes equally often, 0 all objects."""
    label_smoothing: float | None = None
    """Share of the target spread over all classes."""
    replicas: int | None = None
    """Augmented variants made of each object, cached (4 kB each)."""
    furniture: float | None = None
    """Share of the draws that are procedural furniture, 0 … 1."""
    stretch: float | None = None
    """Each axis is scaled by up to this share in augmentation."""
    partial: float | None = None
    """Share of the variants that hold only what a scan of a part of the object sees, 0 … 1."""
    damage: float | None = None
    """Share of the variants that miss a large part, lean or have points floating about, 0 … 1."""
    scans: bool = False
    """Train on simulated scans, from one view to a full orbit, with visibility, size in metres and
    a class of other things: what a robot sees."""
    catalogue: tuple[Path, ...] = ()
    """With --scans: packs of meshes in metres, as `circumspect data import` makes them."""
    catalogue_share: float | None = None
    """With --catalogue: share of the draws that are of them, 0 … 1."""
    catalogue_replicas: int | None = None
    """With --catalogue: scans made of each of their objects, cached (8 kB each)."""
    furniture_each: int | None = None
    """With --furniture: pieces made of each category."""
    furniture_others: int | None = None
    """With --furniture and --scans: things made of each other kind."""
    draws: int | None = None
    """With --scans: objects an epoch; as many as there are by default."""
    random_yaw: bool = False
    """Turn every variant of every object about the vertical by a random angle, as the papers of
    VoxNet, 3DShapeNets and PointNet do. Off, the network sees 0° alone, like the shipped
    classifiers and every figure that is not labelled otherwise; on, what it knows of a turn is
    learnt."""
    validation: bool = True
    """Train on all objects and keep the last epoch; without it some are held back, and if they are
    100 or more, the epoch that names them best is kept."""
    validation_salt: str = ""
    """Another text holds back other objects."""
    precision: Literal["fp32", "bf16"] = "fp32"
    """bf16 is automatic mixed precision."""
    seed: int = 0
    """Of all chance."""
    cache: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = field(default=None)
    """Where grids are kept; $CIRCUMSPECT_CACHE or ~/.cache/circumspect by default."""

    def run(self) -> int:
        """Train, and say what was reached."""
        try:
            from circumspect.training import train
            from circumspect.training.draws import passes_for
        except ImportError as error:
            raise MissingExtraError(error.name or "torch", "train") from error
        from circumspect.cli.freed_memory import keep_freed_memory
        from circumspect.cli.progress import progress_bar, speaks
        from circumspect.cli.say import say
        from circumspect.cli.training_progress import TrainingProgress
        from circumspect.datasets import GridCache, open_data_set
        from circumspect.nets.registry import net_spec, require_takes, require_turnable

        net = net_spec(pooled_net(self.net, self.pool)).name
        # What is wrong with the flags is told before meshes are sampled.
        settings = self._settings(net)
        shards = self._shards()
        recipe = self._recipe(settings) if shards is None else shards.recipe
        require_takes(net, recipe)
        if settings.random_yaw:
            require_turnable(net)
        catalogues = self._catalogues()
        objects: ObjectSet | ShardedTraining
        if shards is not None:
            objects = shards
        else:
            with progress_bar("sampling meshes") as progress:
                objects = open_data_set(Path(self.data), "train", progress)
            if self.passes is None and (passes := passes_for(len(objects))) > 1:
                settings = replace(settings, passes=passes)
                if speaks():
                    few = f"{len(objects)} objects are few"
                    say(f"{few}: an epoch shows all {passes} times (--passes)")
        out = self.out or Path("runs") / f"train-{net}"
        keep_freed_memory()
        with TrainingProgress(settings.epochs) as observer:
            cache = GridCache(self.cache)
            checkpoint = train(
                objects, settings, out, observer, cache, recipe, catalogues=catalogues
            )
        reached = checkpoint.training["reached"]
        accuracy = reached.get("validation_accuracy")
        kept = f"epoch {reached['epoch']}" + (
            "" if accuracy is None else f", mean-class accuracy {accuracy:.4f} on validation"
        )
        if speaks():
            print(f"{out / 'best.safetensors'}: {kept}")  # noqa: T201
        return 0

    def _shards(self) -> ShardedTraining | None:
        """The set, where it is in shards."""
        from circumspect.datasets.sharded_set import is_sharded
        from circumspect.training.sharded_training import ShardedTraining

        if not is_sharded(self.data):
            return None
        if idle := given_flags(self, *OF_OBJECTS):
            raise InputError(f"{idle[0]} goes with a set of objects; {self.data} holds shards")
        return ShardedTraining.read(self.data)

    def _catalogues(self) -> list[LabelledSurfaces]:
        if not self.scans and (idle := given_flags(self, *OF_SCANS)):
            raise InputError(f"{idle[0]} goes with --scans")
        if not self.catalogue and (idle := given_flags(self, *OF_CATALOGUES)):
            raise InputError(f"{idle[0]} goes with --catalogue")
        from circumspect.datasets.catalogue import read_catalogue

        return [read_catalogue(path) for path in self.catalogue]

    def _recipe(self, settings: TrainingSettings) -> InputRecipe:
        from circumspect.classification import GridRecipe
        from circumspect.training.train import recipe_for

        net, recipe = settings.net, recipe_for(settings)
        if isinstance(recipe, GridRecipe):
            return replace(recipe, kind=self.grid or recipe.kind, shape=self.cells or recipe.shape)
        if self.grid or self.cells:
            raise InputError(f"{net} takes points; leave out --grid and --cells")
        return recipe

    def _settings(self, net: str) -> TrainingSettings:
        from circumspect.datasets import Augmentation
        from circumspect.nets.registry import net_spec
        from circumspect.training import TrainingSettings

        known = {f.name for f in fields(TrainingSettings)} & {f.name for f in fields(self)}
        given = {name: getattr(self, name) for name in known}
        given = {name: value for name, value in given.items() if value is not None}
        # The flag of the share has another name than the setting: the files are the catalogue.
        given.pop("catalogue")
        if self.catalogue_share is not None or not self.catalogue:
            given["catalogue"] = self.catalogue_share or 0.0
        changes = {name: getattr(self, name) for name in CHANGES}
        changes = {name: value for name, value in changes.items() if value is not None}
        given |= {"augmentation": Augmentation(**changes)}
        settings = TrainingSettings.of_net(net_spec(net), **given)
        if not settings.augmented and (idle := given_flags(self, *CHANGES)):
            raise InputError(f"{net} is shown objects as they are; leave out {', '.join(idle)}")
        return settings


def pooled_net(net: str, pool: str | None) -> str:
    """The name of a network with the pooling asked for.

    Raises:
        InputError: The network has no choice of pooling.
    """
    if pool is None:
        return net
    if net != "moon2018":
        raise InputError(f"--pool is moon2018's; {net} has no choice of pooling")
    return net if pool == "rwmp" else f"{net}-{pool}"
