"""`circumspect classify FILE…`."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.cli.floor import floor_cut_of, floor_record, say_of_floor
from circumspect.cli.model_flag import ROBOT, ModelFlag
from circumspect.cli.object_cloud import object_cloud
from circumspect.cli.say import say
from circumspect.cli.unit import Unit, grid_in_metres, metres_per_unit
from circumspect.errors import CircumspectError, InputError, blamed_on, printable

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from circumspect.classification import Classifier, Prediction
    from circumspect.grid import OccupancyGrid


@dataclass(frozen=True)
class Classify:
    """Class and probabilities of meshes, point clouds and grids, whatever their yaw.

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
    """The axis that points up in the files; by default y for glTF/GLB, what the file says for USD,
    and z for all others. auto tries the default first, then every face that the object can stand
    on. Saved grids have their axis already."""
    cut_floor: bool = False
    """The files hold the floor, too: find it, remove it and what stands beside the object, and
    level the rest. With --up auto the floor's normal is up."""
    unit: Unit | None = None
    """The unit of the coordinates, also of a saved grid's bounds; with it the object's size is
    used. By default m for glTF/GLB files, and unknown for all others."""
    reader: Annotated[str | None, tyro.conf.arg(metavar="NAME|MODULE:NAME")] = None
    """A reader of your own that reads the files, whatever their suffix; MODULE:NAME is a function
    from a path to a PointCloud or a TriangleMesh. Installed readers read their suffixes without
    this flag."""
    json: bool = False
    """One JSON object a line on standard output and nothing else there."""
    model: ModelFlag = ROBOT
    """A shipped classifier (`circumspect models` lists them), or an ONNX file of your own that
    `circumspect export` made."""
    input_spec: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """TOML or JSON that describes an ONNX file of another program (docs/own-network.md); by
    default NAME.input.toml or NAME.input.json beside NAME.onnx."""
    samples: int = 32768
    """Points sampled on a mesh."""
    threads: int = 0
    """Threads of the network; 0 means all cores."""
    top: int = field(default=3)
    """How many classes to print for each file."""

    def run(self) -> int:
        """Name each file; a file that fails does not stop the others."""
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
                with blamed_on(file):
                    record = self._named(file, classifier)
            except CircumspectError as error:
                failed = True
                say(str(error))
            else:
                self._tell(record)
        return 2 if failed else 0

    def _named(self, file: Path, classifier: Classifier) -> dict[str, Any]:
        start, unit_m = time.perf_counter(), metres_per_unit(file, self.unit)
        metric = unit_m is not None
        grid = None if self.reader else saved_grid(file, self.up)
        if grid is not None:
            points, loaded = int(grid.occupied.sum()), time.perf_counter()
            prediction = classifier.classify_grid(grid_in_metres(grid, unit_m), metric=metric)
            return prediction_record(file, prediction, points, 1e3 * (loaded - start))
        cloud = object_cloud(file, self.up, self.samples, unit_m, self.reader)
        auto, more = self.up == "auto", {}
        if self.cut_floor and (cut := floor_cut_of(file, cloud, auto)) is not None:
            cloud, auto = cut.levelled(), False
            more["floor"] = floor_record(cut)
            if self.up == "auto":
                more["up_xyz"] = cut.plane.normal_xyz.round(4).tolist()
        points, loaded = len(cloud), time.perf_counter()
        if auto:
            from circumspect.classification.upright import classify_any_way_up

            prediction, pose = classify_any_way_up(classifier, cloud, metric=metric)
            more["up_xyz"] = up_of(pose)
        else:
            prediction = classifier.classify(cloud, metric=metric)
        if not self.cut_floor:
            say_of_floor(file, cloud, auto, prediction)
        return prediction_record(file, prediction, points, 1e3 * (loaded - start)) | more

    def _tell(self, record: dict[str, Any]) -> None:
        line = json.dumps(record) if self.json else _readable(record, self.top)
        print(line, flush=True)  # noqa: T201


def require_reader(name: str) -> None:
    """Check `--reader` before files are read.

    Raises:
        InputError: No reader of that name, or one that can not be used.
    """
    from circumspect.geometry.cloud_files import READER_REGISTRY

    READER_REGISTRY.get(name)


def saved_grid(file: Path, up: str | None) -> OccupancyGrid | None:
    """The grid in a file that `circumspect grid` wrote, None for any other file.

    Args:
        file: Of any kind.
        up: What `--up` says; a grid has its axis already.

    Raises:
        InputError: A broken grid, or one that is to be turned.
    """
    if file.suffix.lower() != ".npz":
        return None
    from circumspect.grid import OccupancyGrid
    from circumspect.grid.grid_file import holds_grid

    if not holds_grid(file):
        return None
    if up not in (None, "z"):
        raise InputError(f"is a grid, which has its axis already; leave --up {up} out")
    return OccupancyGrid.load(file)


def prediction_record(
    file: Path, prediction: Prediction, points: int, load: float
) -> dict[str, Any]:
    """What `--json` prints of an answer.

    Args:
        file: What was read.
        prediction: The answer.
        points: How many it is about, or occupied cells.
        load: Time to read the file [ms].
    """
    times = {"load": load, "grid": 0.0, **prediction.milliseconds}
    answer = replace(prediction, milliseconds=times).to_dict()
    told = answer.pop("milliseconds")
    return {"file": str(file), **answer, "points": points, "milliseconds": told}


def up_of(pose: Rotation) -> list[float]:
    """The direction that points up in a file's own coordinates, where it had to be found."""
    return pose.inv().apply([0.0, 0.0, 1.0]).round(4).tolist()


def told_up(record: dict[str, Any]) -> str:
    """The same in words; nothing where it was known."""
    up = record.get("up_xyz")
    return "" if up is None else f"; up is ({', '.join(f'{value:.2f}' for value in up)})"


def _readable(record: dict[str, Any], top: int) -> str:
    from circumspect.classification.answer_text import percent

    best = sorted(record["probabilities"].items(), key=lambda item: -item[1])[:top]
    named = record["alternatives"] or (record["label"],)
    others = ", ".join(f"{name} {percent(share)}" for name, share in best if name not in named)
    then = f", then {others}" if others else ""
    answer = f"{printable(record['file'])}: {record_text(record)}{then}"
    return answer + told_up(record) + told_reason(record)


def record_text(record: dict[str, Any]) -> str:
    """The answer of a record in words."""
    from circumspect.classification.answer_text import answer_text

    keys = ("label", "probability", "in_distribution", "alternatives")
    return answer_text(**{key: record[key] for key in keys})


def told_reason(record: dict[str, Any]) -> str:
    """Why the answer of a record is not confident; nothing where it is."""
    return f"; not confident: {record['reason']}" if record["reason"] else ""
