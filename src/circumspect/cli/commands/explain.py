"""`circumspect explain FILE`."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.commands.classify import (
    prediction_record,
    reason_text,
    record_text,
    saved_grid,
    up_of,
    up_text,
)
from circumspect.cli.floor import object_to_name, print_floor_hint
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.object_cloud import (
    Unit,
    grid_in_metres,
    metres_per_unit,
    object_cloud,
    unit_shown,
)
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, naming_file, printable

if TYPE_CHECKING:
    from circumspect.classification import (
        ExampleTable,
        NearExample,
        OnnxClassifier,
    )
    from circumspect.classification.explanation import Explanation


@dataclass(frozen=True)
class Explain:
    """Explain an answer: the cells that support it, and similar training objects.

    $ circumspect explain chair.ply
    $ circumspect explain chair.ply --label sofa --out why
    $ circumspect explain desk.stl --unit mm
    $ circumspect explain phone-scan.ply --cut-floor
    """

    file: Annotated[Path, tyro.conf.Positional]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, CSV, NPY, NPZ, or a grid saved by `circumspect grid`."""
    out: Path = Path()
    """Output folder for FILE-why.png, FILE-why.ply and FILE-why.npz."""
    label: str | None = None
    """Class to explain; that of the answer by default."""
    near: int = 5
    """Number of nearest training objects to list; 0 for none."""
    up: Literal["x", "y", "z", "auto"] | None = None
    """Axis that points up in the file. Default: y for glTF/GLB, the axis stated in the file for
    USD, z for all others. auto tries every face that the object can stand on, and shows the object
    on the most probable one. A saved grid already has its axis."""
    cut_floor: bool = False
    """Find the floor in the file, remove it and everything beside the object, and level the rest.
    With --up auto, the normal of the floor points up."""
    unit: Unit | None = None
    """Unit of the coordinates, also of the bounds of a saved grid. If the unit is known, the
    classifier uses the size of the object, and the output is in metres. Default: m for glTF/GLB,
    unknown for all others."""
    json: bool = False
    """Print one JSON object on standard output and nothing else."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    examples: Path | None = None
    """Table of the classifier's training objects, written by `export --examples`; by default the
    one beside the file of the classifier."""
    samples: int = 32768
    """Number of points sampled on a mesh."""
    threads: int = 0
    """Number of threads of the network; 0 means all cores."""

    def run(self) -> int:
        """Explain, save and draw."""
        from circumspect.classification import Classifier

        if self.near < 0:
            raise InputError(f"--near {self.near}: give 0 or more")
        start = time.perf_counter()
        classifier = Classifier.load(self.model, self.threads)
        table = self._table() if self.near else None
        with naming_file(self.file):
            found, more = self._explained(classifier)
        if self.near and table is None:
            say(
                f"no nearest training objects: {self.model} has no table of them; circumspect "
                "export --examples writes one"
            )
        near = self._nearest(classifier, found, table)
        record = self._record(found, near, 1e3 * (time.perf_counter() - start))
        record |= more
        record["files"] = self._save(found, near)
        print(json.dumps(record) if self.json else _readable(record))  # noqa: T201
        return 0

    def _explained(self, classifier: OnnxClassifier) -> tuple[Explanation, dict[str, Any]]:
        """The explanation, and the entries of the record about floor and upward direction."""
        from circumspect.classification.explanation import explain_cloud, explain_grid
        from circumspect.cli.progress import progress_bar

        unit_m, metric = self._unit_m, self._unit_m is not None
        grid = saved_grid(self.file, self.up, self.cut_floor)
        if grid is not None:
            grid = grid_in_metres(grid, unit_m)
            with progress_bar("emptying cells") as progress:
                return explain_grid(classifier, grid, self.label, progress, metric=metric), {}
        cloud = object_cloud(self.file, self.up, self.samples, unit_m)
        shown = object_to_name(self.file, cloud, self.up, self.cut_floor)
        cloud, more, prediction = shown.cloud, shown.record, None
        if shown.up_unknown:
            from circumspect.classification.upright import classify_any_way_up, stood

            prediction, pose = classify_any_way_up(classifier, cloud, metric=metric)
            cloud, more = stood(cloud, pose), {"up_xyz": up_of(pose)}
        with progress_bar("emptying cells") as progress:
            found = explain_cloud(classifier, cloud, self.label, progress, metric=metric)
        if prediction is not None:
            # The answer may be not confident because of other poses.
            found = replace(found, evidence=replace(found.evidence, prediction=prediction))
        if not self.cut_floor:
            print_floor_hint(self.file, cloud, shown.up_unknown, found.evidence.prediction)
        return found, more

    @property
    def _unit_m(self) -> float | None:
        return metres_per_unit(self.file, self.unit)

    def _table(self) -> ExampleTable | None:
        """The training objects of the network; None if there is no table."""
        from circumspect.classification import ExampleTable
        from circumspect.classification.example_table import examples_path
        from circumspect.classification.shipped import model_path

        if self.examples is not None:
            return ExampleTable.load(self.examples)
        beside = examples_path(model_path(self.model))
        return ExampleTable.load(beside) if beside.is_file() else None

    def _nearest(
        self, classifier: OnnxClassifier, found: Explanation, table: ExampleTable | None
    ) -> tuple[NearExample, ...]:
        from circumspect.classification import nearest_examples

        if table is None:
            return ()
        return nearest_examples(
            classifier, found.shown, self.near, table, metric=self._unit_m is not None
        )

    def _record(
        self, found: Explanation, near: tuple[NearExample, ...], spent: float
    ) -> dict[str, Any]:
        explained = found.evidence
        prediction = replace(found.evidence.prediction, milliseconds={"explain": spent})
        record = prediction_record(self.file, prediction, len(found.surface), 0.0)
        del record["milliseconds"]
        return {
            **record,
            "explained": explained.label,
            "log_odds": round(explained.log_odds, 4),
            "evidence": explained.to_dict(),
            "nearest": [{**asdict(n), "distance": round(n.distance, 5)} for n in near],
            "milliseconds": round(spent, 1),
        }

    def _save(self, found: Explanation, near: tuple[NearExample, ...]) -> dict[str, str]:
        stem = self.out / f"{self.file.stem}-why"
        files = {kind: stem.with_name(f"{stem.name}.{kind}") for kind in ("npz", "ply", "png")}
        found.evidence.save(files["npz"])
        found.save_ply(files["ply"])
        try:
            from circumspect.evaluation.evidence_picture import draw_evidence
            from circumspect.evaluation.figures import save_figure

            unit = unit_shown(self._unit_m)
            save_figure(draw_evidence(found.evidence, found.surface, near, unit), files["png"])
        except MissingExtraError as error:
            say(f"no picture: {error}")
            del files["png"]
        return {kind: str(path) for kind, path in files.items()}


def _readable(record: dict[str, Any]) -> str:
    evidence, file = record["evidence"], printable(record["file"])
    lines = [
        f"{file}: {record_text(record)}{up_text(record)}{reason_text(record)}",
        f"evidence for {record['explained']}: {evidence['least']:+.2f} to "
        f"{evidence['most']:+.2f} of log-odds {record['log_odds']:+.2f};",
        f"  {100 * evidence['half_of_it_in']:.0f} % of the cells hold half of what speaks for it",
    ]
    if record["nearest"]:
        lines.append("nearest training objects, by distance of features:")
        lines += [f"  {printable(n['name']):<20} {n['distance']:.3f}" for n in record["nearest"]]
    return "\n".join([*lines, *map(printable, record["files"].values())])
