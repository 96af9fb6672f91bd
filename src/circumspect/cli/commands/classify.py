"""`circumspect classify FILE…`."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.floor import object_to_name, print_floor_hint
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.object_cloud import Unit, grid_in_metres, metres_per_unit, object_cloud
from circumspect.cli.say import say
from circumspect.errors import CircumspectError, InputError, naming_file, printable

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from circumspect.classification import Classifier, Prediction
    from circumspect.grid import OccupancyGrid


@dataclass(frozen=True)
class Classify:
    """Print class and probabilities of meshes, point clouds and grids, at any yaw.

    $ circumspect classify chair.ply
    $ circumspect classify scans/*.pcd --json
    $ circumspect classify desk.stl --unit mm
    $ circumspect classify model.glb --up z
    $ circumspect classify fallen.ply --up auto
    $ circumspect classify phone-scan.ply --cut-floor
    """

    files: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE...")]
    """OFF, PLY, OBJ, STL, GLB, PCD, XYZ, CSV, NPY, NPZ, or a grid saved by `circumspect grid`."""
    up: Literal["x", "y", "z", "auto"] | None = None
    """Axis that points up in the files. Default: y for glTF/GLB, the axis stated in the file for
    USD, z for all others. auto tries the default first, then every face that the object can stand
    on. Saved grids already have their axis."""
    cut_floor: bool = False
    """Find the floor in the files, remove it and everything beside the object, and level the rest.
    With --up auto, the normal of the floor points up."""
    unit: Unit | None = None
    """Unit of the coordinates, also of the bounds of a saved grid. If the unit is known, the
    classifier uses the size of the object. Default: m for glTF/GLB, unknown for all others."""
    reader: Annotated[str | None, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = None
    """Your own reader for the files, whatever their suffix. MODULE:NAME is a function from a path
    to a PointCloud or a TriangleMesh. Installed readers read their suffixes without this flag."""
    json: bool = False
    """Print one JSON object per line on standard output and nothing else."""
    model: ModelFlag = ROBOT
    """Shipped classifier (`circumspect models` lists them), or your own ONNX file written by
    `circumspect export`."""
    input_spec: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """TOML or JSON file that describes an ONNX file of another program (docs/own-network.md).
    Default: NAME.input.toml or NAME.input.json beside NAME.onnx."""
    samples: int = 32768
    """Number of points sampled on a mesh."""
    threads: int = 0
    """Number of threads of the network; 0 means all cores."""
    top: int = field(default=3)
    """Number of classes to print for each file."""

    def run(self) -> int:
        """Classify each file; a file that fails does not stop the others."""
        from circumspect.classification import Classifier

        if self.top < 1:
            raise InputError(f"--top {self.top}: give 1 or more")
        if not self.files:
            raise CircumspectError("nothing to classify; give at least one file")
        if self.reader is not None:
            require_reader(self.reader)
        classifier = Classifier.load(self.model, self.threads, self.input_spec)
        failed = False
        for file in self.files:
            try:
                with naming_file(file):
                    record = self._classified(file, classifier)
            except CircumspectError as error:
                failed = True
                say(str(error))
            else:
                self._print(record)
        return 2 if failed else 0

    def _classified(self, file: Path, classifier: Classifier) -> dict[str, Any]:
        start, unit_m = time.perf_counter(), metres_per_unit(file, self.unit)
        metric = unit_m is not None
        grid = None if self.reader else saved_grid(file, self.up, self.cut_floor)
        if grid is not None:
            points, loaded = int(grid.occupied.sum()), time.perf_counter()
            prediction = classifier.classify_grid(grid_in_metres(grid, unit_m), metric=metric)
            return prediction_record(file, prediction, points, 1e3 * (loaded - start))
        cloud = object_cloud(file, self.up, self.samples, unit_m, self.reader)
        shown = object_to_name(file, cloud, self.up, self.cut_floor)
        cloud, more = shown.cloud, shown.record
        points, loaded = len(cloud), time.perf_counter()
        if shown.up_unknown:
            from circumspect.classification.upright import classify_any_way_up

            prediction, pose = classify_any_way_up(classifier, cloud, metric=metric)
            more = {"up_xyz": up_of(pose)}
        else:
            prediction = classifier.classify(cloud, metric=metric)
        if not self.cut_floor:
            print_floor_hint(file, cloud, shown.up_unknown, prediction)
        return prediction_record(file, prediction, points, 1e3 * (loaded - start)) | more

    def _print(self, record: dict[str, Any]) -> None:
        line = json.dumps(record) if self.json else _readable(record, self.top)
        print(line, flush=True)  # noqa: T201


def require_reader(name: str) -> None:
    """Check `--reader` before files are read.

    Raises:
        InputError: There is no reader of that name, or it can not be used.
    """
    from circumspect.geometry.formats.cloud_files import READER_REGISTRY

    READER_REGISTRY.get(name)


def saved_grid(file: Path, up: str | None, cut_floor: bool = False) -> OccupancyGrid | None:
    """The grid in a file written by `circumspect grid`; None for any other file.

    Args:
        file: Any file.
        up: Value of `--up`; a grid already has its axis.
        cut_floor: Whether `--cut-floor` was given; a grid has no points to remove.

    Raises:
        InputError: The grid is broken, or `up` or `cut_floor` does not apply to it.
    """
    if file.suffix.lower() != ".npz":
        return None
    from circumspect.grid import OccupancyGrid
    from circumspect.grid.grid_file import holds_grid

    if not holds_grid(file):
        return None
    if up not in (None, "z"):
        raise InputError(f"is a grid, which has its axis already; leave --up {up} out")
    if cut_floor:
        raise InputError("is a grid, whose floor can not be removed; leave --cut-floor out")
    return OccupancyGrid.load(file)


def prediction_record(
    file: Path, prediction: Prediction, points: int, load: float
) -> dict[str, Any]:
    """The record of an answer that `--json` prints.

    Args:
        file: The input file.
        prediction: The answer.
        points: Number of points, or of occupied cells.
        load: Time to read the file [ms].
    """
    times = {"load": load, "grid": 0.0, **prediction.milliseconds}
    answer = replace(prediction, milliseconds=times).to_dict()
    milliseconds = answer.pop("milliseconds")
    return {"file": str(file), **answer, "points": points, "milliseconds": milliseconds}


def up_of(pose: Rotation) -> list[float]:
    """The upward direction in the coordinates of the file, from the estimated pose."""
    return pose.inv().apply([0.0, 0.0, 1.0]).round(4).tolist()


def up_text(record: dict[str, Any]) -> str:
    """The estimated upward direction in words; empty if it was given."""
    up = record.get("up_xyz")
    return "" if up is None else f"; up is ({', '.join(f'{value:.2f}' for value in up)})"


def _readable(record: dict[str, Any], top: int) -> str:
    from circumspect.classification.answer_text import percent

    best = sorted(record["probabilities"].items(), key=lambda item: -item[1])[:top]
    named = record["alternatives"] or (record["label"],)
    others = ", ".join(f"{name} {percent(share)}" for name, share in best if name not in named)
    then = f", then {others}" if others else ""
    answer = f"{printable(record['file'])}: {record_text(record)}{then}"
    return answer + up_text(record) + reason_text(record)


def record_text(record: dict[str, Any]) -> str:
    """The answer of a record in words."""
    from circumspect.classification.answer_text import answer_text

    keys = ("label", "probability", "in_distribution", "alternatives")
    return answer_text(**{key: record[key] for key in keys})


def reason_text(record: dict[str, Any]) -> str:
    """The reason why the answer of a record is not confident; empty if it is."""
    return f"; not confident: {record['reason']}" if record["reason"] else ""
