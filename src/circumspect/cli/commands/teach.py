"""`circumspect teach NAME FILE…`."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.commands.classify import saved_grid
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.object_cloud import Unit, cloud_in_metres, grid_in_metres, metres_per_unit
from circumspect.errors import InputError, naming_file, printable

if TYPE_CHECKING:
    from circumspect.classification import ExampleTable, OnnxClassifier
    from circumspect.classification.taught_classes import TaughtClass
    from circumspect.evaluation.teaching import Example, TeachingReport
    from circumspect.grid import OccupancyGrid

RUN_GRID = "grid.npz"
"""File in the folder of a run: occupancy grid of the object, in metres."""


@dataclass(frozen=True)
class Teach:
    """Add a class to a classifier from a few examples, without training or data set.

    $ circumspect teach lamp lamps/*.glb
    $ circumspect teach lamp runs/lamp-*
    $ circumspect teach fan fans/*.ply --unit m --model robot-lamp
    $ circumspect classify lamp.glb --model robot-lamp

    Answers for objects that do not resemble the examples do not change.
    """

    name: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="NAME")]
    """Name of the new class: letters, digits, - and _."""
    examples: Annotated[
        tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE|RUN...")
    ]
    """At least five different objects of the class: files in the formats of `circumspect classify`,
    saved grids, or folders of runs (scan, replay)."""
    model: ModelFlag = ROBOT
    """Classifier to extend: name of a shipped or taught one (see `circumspect models`), or an ONNX
    file written by `circumspect export`."""
    out: Annotated[str | None, tyro.conf.arg(metavar="NAME|FILE.json")] = None
    """New classifier: a name for `--model`, or a file. Default: MODEL-NAME, or a file beside MODEL
    if that is your own ONNX file."""
    replace: bool = False
    """Overwrite a taught classifier of that name."""
    up: Literal["x", "y", "z"] = "z"
    """Axis that points up in the files."""
    unit: Unit | None = None
    """Unit of the coordinates, see `circumspect classify`."""
    samples: int = 32768
    """Number of points sampled on a mesh."""
    json: bool = False
    """Print one JSON object on standard output and nothing else."""

    def run(self) -> int:
        """Add the class, measure the accuracy and write the classifier."""
        from circumspect.classification import Classifier
        from circumspect.classification.shipped import OWN_NAME
        from circumspect.evaluation.teaching import Teacher

        if not OWN_NAME.fullmatch(self.name):
            raise InputError(f"{self.name!r} is no name of a class; use letters, digits, - and _")
        out = self._out()
        classifier = Classifier.load(self.model)
        shown = [self._example(path, classifier) for path in self.examples]
        teacher = Teacher(classifier, self.name, shown, self._table())
        report = teacher.report()
        if 2 * report.named < report.examples:
            raise InputError(
                f"taught from the others, {report.named} of {report.examples} examples get the "
                f"name {self.name}; nothing was written: give more examples, or of one kind"
            )
        self._write(out, teacher.taught(), classifier, shown, report)
        document = {"name": _model_name(out), "file": str(out), **report.to_dict()}
        print(json.dumps(document) if self.json else _readable(document, self.name))  # noqa: T201
        return 0

    def _out(self) -> Path:
        """The file to write.

        Raises:
            InputError: It exists, or is no valid name for a taught classifier.
        """
        from circumspect.classification.shipped import OWN_NAME, SHIPPED, own_model_path

        base, network = _network(self.model)
        wanted = self.out or f"{Path(self.model).stem}-{self.name}"
        if base is None and self.out is None:
            wanted = str(network.with_name(f"{wanted}.json"))
        if wanted in SHIPPED:
            raise InputError(f"--out {wanted}: the name of a shipped classifier; choose another")
        path = own_model_path(wanted) if OWN_NAME.fullmatch(wanted) else Path(wanted)
        if path.suffix.lower() != ".json" or path.name.endswith((".card.json", ".input.json")):
            raise InputError(f"--out {wanted}: give a name, or a file that ends in .json")
        if base is None and network.absolute().parent != path.absolute().parent:
            raise InputError(
                f"--out {wanted}: must lie beside {network}, which it refers to: --out "
                f"{network.parent / path.name}"
            )
        if path.exists() and not self.replace:
            raise InputError(f"{path}: exists; --replace overwrites it, --out names another one")
        return path

    def _example(self, path: Path, classifier: OnnxClassifier) -> Example:
        from circumspect.errors import CircumspectError
        from circumspect.evaluation.teaching import Example
        from circumspect.geometry import read_cloud

        if path.is_dir():
            if not (path / RUN_GRID).is_file():
                raise InputError(f"{path}: holds no {RUN_GRID}; give folders of finished runs")
            with naming_file(path / RUN_GRID):
                return _of_grid(path / RUN_GRID, saved_grid(path / RUN_GRID, "z"), classifier, True)
        unit_m = metres_per_unit(path, self.unit)
        metric = unit_m is not None
        try:
            with naming_file(path):
                if (grid := saved_grid(path, self.up)) is not None:
                    return _of_grid(path, grid_in_metres(grid, unit_m), classifier, metric)
                read = read_cloud(path, up=self.up, samples=self.samples)
                cloud = cloud_in_metres(read, unit_m)
                return Example.of_cloud(str(path), cloud, classifier, metric, _sha256(path))
        except CircumspectError as error:
            raise InputError(str(error)) from error

    def _table(self) -> ExampleTable | None:
        """The training objects of the extended classifier; None if there is no table."""
        from circumspect.classification import ExampleTable
        from circumspect.classification.example_table import examples_path

        table = examples_path(_network(self.model)[1])
        return ExampleTable.load(table) if table.is_file() else None

    def _write(
        self,
        out: Path,
        taught: TaughtClass,
        classifier: OnnxClassifier,
        shown: list[Example],
        report: TeachingReport,
    ) -> None:
        from circumspect.classification.model_card import CardFigure, ModelCard, card_path
        from circumspect.classification.taught_file import TaughtFile

        base, network = _network(self.model)
        earlier = _earlier_hashes(self.model)
        base = base or network.name
        hashes = {**earlier, self.name: tuple(one.sha256 for one in shown)}
        classes = (*classifier.taught, taught)
        out.parent.mkdir(parents=True, exist_ok=True)
        TaughtFile(base, _sha256(network), classes, hashes).save(out)
        figure = CardFigure(
            "leave-one-out accuracy", report.named / report.examples, "share",
            f"{report.examples} examples of {self.name}", f"circumspect teach {self.name}",
            headline=True,
        )  # fmt: skip
        ModelCard(_sha256(out), (figure,)).save(card_path(out))


def _of_grid(
    path: Path, grid: OccupancyGrid | None, classifier: OnnxClassifier, metric: bool
) -> Example:
    from circumspect.evaluation.teaching import Example

    if grid is None:
        raise InputError("is no grid")
    input_spec = classifier.input_spec
    inputs = input_spec.input_of(grid)[None, None]
    context = input_spec.context(inputs[0], grid.grid if metric else None)
    return Example(str(path), inputs, context, _sha256(path))


def _network(model: str) -> tuple[str | None, Path]:
    """The name of the shipped base classifier, if it is one, and the ONNX file."""
    from circumspect.classification.shipped import SHIPPED, model_path, shipped_name
    from circumspect.classification.taught_file import SUFFIX, TaughtFile

    path = model_path(model)
    if path.suffix.lower() == SUFFIX:
        taught = TaughtFile.load(path)
        return taught.base if taught.base in SHIPPED else None, taught.base_path(path)
    return shipped_name(model), path


def _earlier_hashes(model: str) -> dict[str, Any]:
    """Hashes of the examples of classes that were added before."""
    from circumspect.classification.shipped import model_path
    from circumspect.classification.taught_file import SUFFIX, TaughtFile

    path = model_path(model)
    return dict(TaughtFile.load(path).examples) if path.suffix.lower() == SUFFIX else {}


def _model_name(out: Path) -> str:
    """The value for `--model`."""
    from circumspect.classification.shipped import own_models_folder

    return out.stem if out.parent == own_models_folder() else str(out)


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _readable(document: dict[str, Any], name: str) -> str:
    from circumspect.classification.answer_text import percent

    def of(part: int, whole: int) -> str:
        return f"{part:,} of {whole:,} ({percent(part / whole)})"

    lines = [
        f"{printable(document['file'])}: the class {name} from {document['examples']} examples",
        f"leave-one-out: {of(document['named'], document['examples'])} named {name}",
    ]
    if document["furniture"]:
        after = of(document["furniture_after"], document["furniture"])
        before = document["furniture_before"]
        lines.append(f"procedural furniture: {after} named correctly, {before:,} before")
    if document["trained"] is not None:
        claimed = of(document["trained_claimed"], document["trained"])
        lines.append(f"training objects of the other classes: {claimed} resemble {name} most")
    things = of(document["things_claimed"], document["things"])
    lines.append(f"other things: {things} named {name}")
    lines.append(f"use it: circumspect classify FILE --model {printable(document['name'])}")
    return "\n".join(lines)
