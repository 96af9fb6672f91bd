"""`circumspect explain FILE`."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.classify import (
    prediction_record,
    record_text,
    saved_grid,
    told_reason,
    told_up,
    up_of,
)
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.object_cloud import object_cloud
from circumspect.cli.say import say
from circumspect.cli.unit import (
    Unit,
    grid_in_metres,
    metres_per_unit,
    unit_shown,
)
from circumspect.errors import InputError, MissingExtraError, blamed_on, printable

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from circumspect.classification import (
        CellEvidence,
        ExampleTable,
        NearExample,
        OnnxClassifier,
    )
    from circumspect.classification.explanation import Explanation


@dataclass(frozen=True)
class Explain:
    """Why an object gets its name: the cells that carry it, and what it resembles.

    $ circumspect explain chair.ply
    $ circumspect explain chair.ply --label sofa --out why
    $ circumspect explain desk.stl --unit mm
    """

    file: Annotated[Path, tyro.conf.Positional]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, CSV, NPY, NPZ, or a grid saved by `circumspect grid`."""
    out: Path = Path()
    """The folder for FILE-why.png, FILE-why.ply and FILE-why.npz; here by default."""
    label: str | None = None
    """The class to ask about; without it the one that is named."""
    near: int = 5
    """How many of the nearest training objects to name; 0 for none."""
    up: Literal["x", "y", "z", "auto"] | None = None
    """The axis that points up in the file; by default y for glTF/GLB, what the file says for USD,
    and z for all others. auto tries every face that the object can stand on, and
    shows it on the most probable one. A saved grid has its axis already."""
    unit: Unit | None = None
    """The unit of the coordinates, also of a saved grid's bounds; with it the object's size is
    used, and what is written is in metres. By default m for glTF/GLB files, and unknown for all
    others."""
    json: bool = False
    """One JSON object on standard output and nothing else there."""
    model: ModelFlag = ROBOT
    """A shipped classifier (`circumspect models` lists them), or an ONNX file of your own that
    `circumspect export` made."""
    examples: Path | None = None
    """Its table of training objects, written by `export --examples`; without it the one beside the
    classifier's file."""
    samples: int = 32768
    """Points sampled on a mesh."""
    threads: int = 0
    """Threads of the network; 0 means all cores."""

    def run(self) -> int:
        """Explain, save and draw."""
        from circumspect.classification import Classifier

        if self.near < 0:
            raise InputError(f"--near {self.near}: give 0 or more")
        start = time.perf_counter()
        classifier = Classifier.load(self.model, self.threads)
        table = self._table() if self.near else None
        with blamed_on(self.file):
            found, pose = self._explained(classifier)
        if self.near and table is None:
            say(
                f"no nearest training objects: {self.model} has no table of them; circumspect "
                "export --examples writes one"
            )
        near = self._nearest(classifier, found, table)
        record = self._record(found, near, 1e3 * (time.perf_counter() - start))
        if pose is not None:
            record["up_xyz"] = up_of(pose)
        record["files"] = self._save(found, near)
        print(json.dumps(record) if self.json else _readable(record))  # noqa: T201
        return 0

    def _explained(self, classifier: OnnxClassifier) -> tuple[Explanation, Rotation | None]:
        """The evidence, and how the object was stood up where nobody knew that."""
        from circumspect.classification.explanation import explain_cloud, explain_grid
        from circumspect.cli.progress import progress_bar

        unit_m, metric = self._unit_m, self._unit_m is not None
        grid = saved_grid(self.file, self.up)
        if grid is not None:
            grid = grid_in_metres(grid, unit_m)
            with progress_bar("emptying cells") as progress:
                return explain_grid(classifier, grid, self.label, progress, metric=metric), None
        cloud = object_cloud(self.file, self.up, self.samples, unit_m)
        pose = None
        if self.up == "auto":
            from circumspect.classification.upright import classify_any_way_up, stood

            _, pose = classify_any_way_up(classifier, cloud, metric=metric)
            cloud = stood(cloud, pose)
        with progress_bar("emptying cells") as progress:
            return explain_cloud(classifier, cloud, self.label, progress, metric=metric), pose

    @property
    def _unit_m(self) -> float | None:
        return metres_per_unit(self.file, self.unit)

    def _table(self) -> ExampleTable | None:
        """What the network was trained on; None where nobody wrote it down."""
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
            "evidence": _summary(explained),
            "nearest": [{**asdict(n), "distance": round(n.distance, 5)} for n in near],
            "milliseconds": round(spent, 1),
        }

    def _save(self, found: Explanation, near: tuple[NearExample, ...]) -> dict[str, str]:
        stem = self.out / f"{self.file.stem}-why"
        files = {kind: stem.with_name(f"{stem.name}.{kind}") for kind in ("npz", "ply", "png")}
        found.save(files["npz"])
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


def _summary(explained: CellEvidence) -> dict[str, Any]:
    from circumspect.classification.explanation import half_share

    return {
        "most": round(float(explained.cells.max()), 4),
        "least": round(float(explained.cells.min()), 4),
        "half_of_it_in": round(half_share(explained), 4),
        "grids_asked": explained.asked,
    }


def _readable(record: dict[str, Any]) -> str:
    evidence, file = record["evidence"], printable(record["file"])
    lines = [
        f"{file}: {record_text(record)}{told_up(record)}{told_reason(record)}",
        f"evidence for {record['explained']}: {evidence['least']:+.2f} to "
        f"{evidence['most']:+.2f} of log-odds {record['log_odds']:+.2f};",
        f"  {100 * evidence['half_of_it_in']:.0f} % of the cells hold half of what speaks for it",
    ]
    if record["nearest"]:
        lines.append("nearest training objects, by distance of features:")
        lines += [f"  {printable(n['name']):<20} {n['distance']:.3f}" for n in record["nearest"]]
    return "\n".join([*lines, *map(printable, record["files"].values())])
