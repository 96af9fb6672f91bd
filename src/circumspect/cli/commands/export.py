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
from circumspect.cli.model_flag import NetFlag, name_net
from circumspect.errors import InputError, MissingExtraError, naming_file, printable

if TYPE_CHECKING:
    from circumspect.classification import InputSpec
    from circumspect.datasets import ObjectSet
    from circumspect.export.conversion import NetworkInputs
    from circumspect.nets import Checkpoint

CALIBRATION = 512
"""Number of training objects: half to measure ranges, half to check the result."""


@dataclass(frozen=True)
class Export:
    """Export trained networks as one ONNX file for the robot.

    $ circumspect export runs/train-planes planes.onnx
    $ circumspect export runs/a fast.onnx --int8 ModelNet10
    $ circumspect export runs/a committee.onnx --committee runs/b runs/c
    $ circumspect export runs/a planes.onnx --examples ModelNet10
    $ circumspect export old.onnx new.onnx --azimuth-views 8 --dithered
    """

    weights: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="RUN")]
    """Checkpoint or folder of a run, or an ONNX file exported before. The latter keeps its weights;
    missing outputs and examples are added."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT.onnx")]
    """ONNX file to write; it is kept only if its outputs agree with those of the input."""
    net: NetFlag = None
    """Code of the network, for a checkpoint whose network is not installed."""
    committee: tuple[Path, ...] = ()
    """Further checkpoints or runs; the logits of all networks are averaged."""
    int8: Annotated[Path | None, tyro.conf.arg(metavar="DATA")] = None
    """Use eight-bit convolutions, with ranges measured on the training objects of this set."""
    azimuth_views: int | None = None
    """Number of grids per object, turned by fractions of an azimuth cell, whose outputs are
    averaged; one by default, unchanged for an ONNX file."""
    dithered: bool = False
    """Also vary the height offset, by fractions of a cell, and the cell size of these grids;
    without this flag they are only turned."""
    temperature: float | None = None
    """Divisor of the logits; above 1 the probabilities are less extreme. 1 by default, unchanged
    for an ONNX file."""
    examples: Annotated[Path | None, tyro.conf.arg(metavar="DATA")] = None
    """Data set that the network was trained on. Its training objects are stored in OUT, for the
    distance of an object to the nearest of them, and in a table beside OUT, from which `circumspect
    explain` lists the nearest."""
    unknown_beyond: float | None = None
    """With --examples: distance from all examples beyond which an object is called unknown. For
    validation, `circumspect evaluate` prints the distance that includes 95 % of the known
    objects."""

    def run(self) -> int:
        """Export, and add the training objects if requested."""
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
        # Wrong flags are reported before data are opened, and errors in the set of examples before
        # anything is written.
        write = self._write_features
        if self.weights.suffix.lower() == ".onnx":
            self._require_exported()
        else:
            write = partial(self._export, self._members())
        objects = None if self.examples is None else self._trained_on(self.examples)
        # After any error there is no file without its examples.
        with draft_of(self.out) as draft:
            lines = [write(draft)]
            if objects is not None:
                lines += self._add_examples(draft, objects)
        print("\n".join(lines))  # noqa: T201
        return 0

    def _require_exported(self) -> None:
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
        self._with_views(classifier.input_spec)

    def _with_views(self, input_spec: InputSpec) -> InputSpec:
        """The input specification with the requested views."""
        if self.azimuth_views is None and not self.dithered:
            return input_spec
        views = input_spec.azimuth_views if self.azimuth_views is None else self.azimuth_views
        if self.dithered and views == 1:
            raise InputError("one grid is dithered with no other; give --azimuth-views 8")
        return input_spec.with_views(views, self.dithered)

    def _write_features(self, draft: Path) -> str:
        """Write an ONNX file with features and the requested views; returns a line of output."""
        from circumspect.classification import Classifier

        try:
            from circumspect.export.description import write_with_input_spec
            from circumspect.export.features import write_with_features
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        write_with_features(self.weights, draft)
        out, weights = printable(str(self.out)), printable(str(self.weights))
        if not given_flags(self, "azimuth_views", "dithered", "temperature"):
            return f"{out}: gives its features, answers as {weights} does"
        before = Classifier.load(draft)
        input_spec = self._with_views(before.input_spec)
        write_with_input_spec(draft, input_spec, self.temperature)
        after = Classifier.load(draft)
        how = f"{input_spec.azimuth_views} {'dithered ' if self.dithered else ''}inputs an object"
        if input_spec == before.input_spec:
            how = "inputs as before"
        line = f"{out}: weights of {weights}, {how}, temperature {after.temperature:g}"
        if before.gives_distances and input_spec != before.input_spec and self.examples is None:
            line += "; --examples DATA makes its training objects over these grids, too"
        return line

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
        with naming_file(data):
            learnt_objects(trained.classes, trained.training, objects)
        return objects

    def _add_examples(self, draft: Path, objects: ObjectSet) -> list[str]:
        """Store the examples in the draft and beside the final file; returns lines of output."""
        from circumspect.classification import Classifier
        from circumspect.classification.example_table import examples_path
        from circumspect.cli.progress import progress_bar
        from circumspect.export.description import write_fitted_names
        from circumspect.export.examples import example_table
        from circumspect.export.nearest import write_with_distance

        lines = []
        if write_fitted_names(draft, objects):
            lines.append(f"{printable(str(self.out))}: names the objects that it was trained on")
        classifier = Classifier.load(draft)
        with progress_bar("training objects") as progress:
            table = example_table(classifier, objects, progress)
        write_with_distance(draft, table, self.unknown_beyond)
        path = examples_path(self.out)
        table.save(path)
        size = path.stat().st_size / 1e6
        return [*lines, f"{printable(str(path))}: {len(table)} training objects, {size:.1f} MB"]

    def _members(self) -> list[Checkpoint]:
        """The loaded networks, checked against the flags."""
        try:
            from circumspect.evaluation.predictor import checkpoint_path
            from circumspect.export.eight_bit import require_convolutions
            from circumspect.nets import Checkpoint
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        paths = (self.weights, *self.committee)
        members = [Checkpoint.load(checkpoint_path(path)) for path in paths]
        self._with_views(members[0].input_spec)
        if self.int8 is not None:
            require_convolutions(members)
        return members

    def _export(self, members: list[Checkpoint], draft: Path) -> str:
        """Export; returns a line about the agreement of the outputs."""
        from circumspect.export import export_onnx

        calibration = None
        if self.int8 is not None:
            calibration = _calibration(self.int8, members[0].input_spec, members[0].training)
        fidelity = export_onnx(
            members, draft, 1 if self.azimuth_views is None else self.azimuth_views,
            1.0 if self.temperature is None else self.temperature, calibration, self.dithered,
        )  # fmt: skip
        size = draft.stat().st_size / 1e6
        return (
            f"{printable(str(self.out))}: {size:.1f} MB, logits within {fidelity.difference:.1g}, "
            f"same label for {fidelity.agreement:.1%}"
        )


def _calibration(data: Path, input_spec: InputSpec, training: Mapping[str, Any]) -> NetworkInputs:
    """Inputs of evenly spaced training objects of a set, as in training."""
    import numpy as np

    from circumspect.cli.progress import progress_bar
    from circumspect.datasets import open_data_set
    from circumspect.evaluation.yaw_sweep import inputs_of
    from circumspect.export.conversion import NetworkInputs
    from circumspect.export.examples import scanned

    with progress_bar("sampling meshes") as progress:
        objects = open_data_set(data, "train", progress)
    chosen = np.unique(np.linspace(0, len(objects) - 1, CALIBRATION).astype(int))
    if input_spec.takes_context:
        with progress_bar("simulated scans") as progress:
            scans = scanned(objects.subset(chosen), training, input_spec.with_views(1), progress)
        return NetworkInputs(scans.inputs[:, 0], scans.contexts)
    grids = [inputs_of(input_spec, objects, int(index), [0.0])[0, 0] for index in chosen]
    return NetworkInputs(np.stack(grids))
