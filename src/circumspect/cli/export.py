"""`circumspect export`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.draft import draft_of
from circumspect.cli.given_flags import given_flags
from circumspect.cli.net_flag import NetFlag, name_net
from circumspect.errors import InputError, MissingExtraError, blamed_on, printable

if TYPE_CHECKING:
    from circumspect.classification import InputRecipe
    from circumspect.datasets import ObjectSet
    from circumspect.export.shown import Shown
    from circumspect.nets import Checkpoint

CALIBRATION = 512
"""Training objects, half of which measure ranges and half of which check the outcome."""


@dataclass(frozen=True)
class Export:
    """Turn trained networks into one ONNX file for the robot.

    $ circumspect export runs/train-planes planes.onnx
    $ circumspect export runs/a fast.onnx --int8 ModelNet10
    $ circumspect export runs/a committee.onnx --committee runs/b runs/c
    $ circumspect export runs/a planes.onnx --examples ModelNet10
    $ circumspect export old.onnx new.onnx --azimuth-views 8 --staggered
    """

    weights: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """A checkpoint, or the folder of a run. Or an ONNX file exported before: what it lacks is
    added, its weights stay."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.onnx")]
    """The ONNX file to write; it is kept only if its network answers as the given ones do."""
    net: NetFlag = None
    """Of a checkpoint whose network is not installed: the network's code."""
    committee: tuple[Path, ...] = ()
    """Further checkpoints or runs, whose logits are averaged with the first's."""
    int8: Annotated[Path | None, tyro.conf.arg(metavar="DATA")] = None
    """A data set; its training objects show which ranges eight-bit convolutions have to span."""
    azimuth_views: int | None = None
    """Average over this many grids an object, turned by fractions of an azimuth cell; one without
    it, of an ONNX file as many as before."""
    staggered: bool = False
    """Cells of these grids also begin at other fractions of a cell in height and are of other
    sizes; --azimuth-views without it are grids that are turned and no more."""
    temperature: float | None = None
    """Divides the logits: above 1 makes the classifier less sure. 1 without it, of an ONNX file
    what it was before."""
    examples: Annotated[Path | None, tyro.conf.arg(metavar="DATA")] = None
    """The data set it was trained on: the objects that it was fitted to go into OUT, by which it
    tells how far an object is from the nearest of them, and into a table beside OUT, by which
    `circumspect explain` names the nearest."""
    unknown_beyond: float | None = None
    """With --examples: objects farther than this from all of them are called unknown; `circumspect
    evaluate` on validation says within what distance 95 % of the known objects are."""

    def run(self) -> int:
        """Export, and add the training objects where asked for."""
        from circumspect.classification.model_description import (
            checked_distance,
            checked_temperature,
        )

        name_net(self.net)
        if self.temperature is not None:
            checked_temperature(self.temperature)
        if self.unknown_beyond is not None:
            if self.examples is None:
                raise InputError("--unknown-beyond is a distance from --examples DATA; give both")
            checked_distance(self.unknown_beyond)
        if self.out.suffix.lower() != ".onnx":
            raise InputError(
                f"{self.out}: what is exported is ONNX; give a name that ends in .onnx"
            )
        # What is wrong with flags is told before data are opened, and what is wrong with the
        # examples' set before anything is written.
        write = self._complete
        if self.weights.suffix.lower() == ".onnx":
            self._keeps_its_weights()
        else:
            write = partial(self._export, self._members())
        objects = None if self.examples is None else self._trained_on(self.examples)
        # Whatever ends it early, there is no file without its examples.
        with draft_of(self.out) as draft:
            told = [write(draft)]
            if objects is not None:
                told += self._remember(draft, objects)
        print("\n".join(told))  # noqa: T201
        return 0

    def _keeps_its_weights(self) -> None:
        from circumspect.classification import Classifier

        if given := given_flags(self, "committee", "int8"):
            raise InputError(
                f"{self.weights}: is exported already and keeps its weights; {given[0]} goes with "
                "checkpoints"
            )
        classifier = Classifier.load(self.weights)
        if "input_spec_sha256" in classifier.description:
            raise InputError(
                f"{self.weights}: of another program, which is used as it is; change its input "
                "specification"
            )
        self._asked(classifier.recipe)

    def _asked(self, recipe: InputRecipe) -> InputRecipe:
        """What a network is shown that was shown this."""
        if self.azimuth_views is None and not self.staggered:
            return recipe
        views = recipe.azimuth_views if self.azimuth_views is None else self.azimuth_views
        if self.staggered and views == 1:
            raise InputError("one grid is staggered with no other; give --azimuth-views 8")
        return recipe.with_views(views, self.staggered)

    def _complete(self, draft: Path) -> str:
        """Write an ONNX file with its features, asked as the flags say; says what it does."""
        from circumspect.classification import Classifier

        try:
            from circumspect.export.description import write_asked_otherwise
            from circumspect.export.features import write_with_features
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        write_with_features(self.weights, draft)
        out, weights = printable(str(self.out)), printable(str(self.weights))
        if not given_flags(self, "azimuth_views", "staggered", "temperature"):
            return f"{out}: gives its features, answers as {weights} does"
        before = Classifier.load(draft)
        recipe = self._asked(before.recipe)
        write_asked_otherwise(draft, recipe, self.temperature)
        after = Classifier.load(draft)
        how = f"{recipe.azimuth_views} {'staggered ' if self.staggered else ''}inputs an object"
        if recipe == before.recipe:
            how = "inputs as before"
        told = f"{out}: weights of {weights}, {how}, temperature {after.temperature:g}"
        if before.gives_distances and recipe != before.recipe and self.examples is None:
            told += "; --examples DATA makes its training objects over these grids, too"
        return told

    def _trained_on(self, data: Path) -> ObjectSet:
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets import open_data_set
        from circumspect.evaluation.predictor import load_predictor

        try:
            from circumspect.export.examples import learnt_objects
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        trained = load_predictor(self.weights)
        with progress_bar("sampling meshes") as progress:
            objects = open_data_set(data, "train", progress)
        with blamed_on(data):
            learnt_objects(trained.classes, trained.training, objects)
        return objects

    def _remember(self, draft: Path, objects: ObjectSet) -> list[str]:
        """Put the examples into the draft and beside the file that it becomes; says what it did."""
        from circumspect.classification import Classifier
        from circumspect.classification.example_table import examples_path
        from circumspect.cli.progress import progress_bar
        from circumspect.export.examples import example_table
        from circumspect.export.fitted_names import write_fitted_names
        from circumspect.export.nearest import write_with_distance

        told = []
        if write_fitted_names(draft, objects):
            told.append(f"{printable(str(self.out))}: names the objects that it was trained on")
        classifier = Classifier.load(draft)
        with progress_bar("training objects") as progress:
            table = example_table(classifier, objects, progress)
        write_with_distance(draft, table, self.unknown_beyond)
        path = examples_path(self.out)
        table.save(path)
        size = path.stat().st_size / 1e6
        return [*told, f"{printable(str(path))}: {len(table)} training objects, {size:.1f} MB"]

    def _members(self) -> list[Checkpoint]:
        """The networks, which fit the flags."""
        try:
            from circumspect.evaluation.predictor import checkpoint_path
            from circumspect.export.eight_bit import require_convolutions
            from circumspect.nets import Checkpoint
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        paths = (self.weights, *self.committee)
        members = [Checkpoint.load(checkpoint_path(path)) for path in paths]
        self._asked(members[0].recipe)
        if self.int8 is not None:
            require_convolutions(members)
        return members

    def _export(self, members: list[Checkpoint], draft: Path) -> str:
        """Export; says how close the outputs are."""
        from circumspect.export import export_onnx

        calibration = None
        if self.int8 is not None:
            calibration = _calibration(self.int8, members[0].recipe, members[0].training)
        fidelity = export_onnx(
            members, draft, 1 if self.azimuth_views is None else self.azimuth_views,
            1.0 if self.temperature is None else self.temperature, calibration, self.staggered,
        )  # fmt: skip
        size = draft.stat().st_size / 1e6
        return (
            f"{printable(str(self.out))}: {size:.1f} MB, logits within {fidelity.difference:.1g}, "
            f"same label for {fidelity.agreement:.1%}"
        )


def _calibration(data: Path, recipe: InputRecipe, training: Mapping[str, Any]) -> Shown:
    """Inputs of training objects, evenly over the set, as they were shown in training."""
    import numpy as np

    from circumspect.cli.progress import progress_bar
    from circumspect.datasets import open_data_set
    from circumspect.evaluation.yaw_sweep import inputs_of
    from circumspect.export.scan_examples import scanned
    from circumspect.export.shown import Shown

    with progress_bar("sampling meshes") as progress:
        objects = open_data_set(data, "train", progress)
    chosen = np.unique(np.linspace(0, len(objects) - 1, CALIBRATION).astype(int))
    if recipe.takes_context:
        with progress_bar("simulated scans") as progress:
            scans = scanned(objects.subset(chosen), training, recipe.with_views(1), progress)
        return Shown(scans.inputs[:, 0], scans.contexts)
    grids = [inputs_of(recipe, objects, int(index), [0.0])[0, 0] for index in chosen]
    return Shown(np.stack(grids))
