"""`circumspect evaluate`."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect import __version__
from circumspect.cli.commands.evaluate_crops import are_crops, evaluate_crops
from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.given_flags import given_flags
from circumspect.cli.job_pool import opened_pool, seen_from
from circumspect.cli.model_flag import MODELNET10, ROBOT, NetFlag, name_net
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from rich.table import Table

    from circumspect.datasets import ObjectSet
    from circumspect.evaluation.evaluation_set import EvaluationSet
    from circumspect.evaluation.predictor import Predictor, TrainedPredictor
    from circumspect.evaluation.yaw_sweep import YawSweep

YAWS = 64
"""Default number of yaws."""


@dataclass(frozen=True)
class Evaluate:
    """Measure the accuracy over many yaws, or on labelled real objects.

    $ circumspect evaluate --data ModelNet10 --split test --yaw-count 64 --out eval
    $ circumspect evaluate --model runs/train-planes --data ModelNet10 --yaw 0,45
    $ circumspect evaluate --data ModelNet10 --split test --corrupt --out robustness
    $ circumspect evaluate --data objects.npz --out real
    $ circumspect evaluate --model runs/train-planes --data shards --split test
    """

    data: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PATH|URL")]
    """Folder with point packs, folder of ModelNet10's OFF files, folder of your own classes as
    <class>/{train,test}/* in any readable format, or a set made by `gather`. Also the folder or URL
    of shards made by `data convert`, or files of labelled real objects (docs/real-objects.md);
    these two are not turned."""
    model: Annotated[str | None, tyro.conf.arg(metavar="NAME|FILE")] = None
    """Shipped classifier (`circumspect models` lists them), ONNX file, checkpoint or folder of a
    run; by default modelnet10 (the paper's protocol), or robot for real objects."""
    input_spec: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """TOML or JSON file that describes an ONNX file of another program (docs/own-network.md).
    Default: NAME.input.toml or NAME.input.json beside NAME.onnx."""
    net: NetFlag = None
    """Code of the network, for a checkpoint whose network is not installed."""
    split: Literal["validation", "test", "train"] = "validation"
    """Split of the set. Use validation for choices, test for reports."""
    yaw: Annotated[str | None, tyro.conf.arg(metavar="DEG,DEG,...")] = None
    """Yaws [degrees], such as 0,45,90,135."""
    yaw_count: int | None = None
    """Number of yaws over a full turn, each at another fraction of a cell, instead of --yaw;
    64 by default."""
    corrupt: bool = False
    """Apply twelve corruptions of five severities each, instead of turning the objects."""
    margin: float | None = None
    """Size of the grid relative to the smallest grid that holds the object; the classifier's own
    margin by default."""
    scale: Literal["metric", "unknown"] = "metric"
    """Real objects only: unknown hides from the classifier that coordinates are in metres."""
    out: Path = Path("evaluation")
    """Output folder for metrics.json and figures."""
    json: bool = False
    """Print the metrics as JSON on standard output and nothing else."""
    threads: int = 0
    """Number of threads of ONNX Runtime; 0 means all cores."""
    workers: int | None = None
    """Shards only: number of processes; one per core by default."""
    cluster: str | None = None
    """Shards only: Ray cluster, "auto" or HOST:PORT. Its nodes must have the shards and the
    classifier under the same paths."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Evaluate, write and print."""
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.sharded_set import is_sharded
        from circumspect.evaluation.evaluation_set import open_evaluation_set
        from circumspect.evaluation.predictor import load_predictor, with_margin
        from circumspect.evaluation.yaw_sweep import spread_yaws, sweep_yaw
        from circumspect.storage import write_json

        name_net(self.net)
        if any(map(is_sharded, self.data)):
            return self._shards()
        if given := given_flags(self, "workers", "cluster"):
            raise InputError(f"{given[0]} goes with shards; `circumspect data convert` makes them")
        paths = [Path(name) for name in self.data]
        if are_crops(paths):
            return self._real_objects(paths)
        if len(paths) != 1:
            raise InputError(f"--data: one set at a time, not {len(paths)}")
        if self.scale != "metric":
            raise InputError("--scale goes with files of labelled real objects")
        data, name = paths[0], self.model or MODELNET10
        given = given_flags(self, "yaw", "yaw_count")
        if self.corrupt and given:
            raise InputError(f"--corrupt is measured at 0°; leave {given[0]} out")
        if len(given) > 1:
            raise InputError("give --yaw or --yaw-count, not both")
        count = YAWS if self.yaw_count is None else self.yaw_count
        yaws = spread_yaws(count) if self.yaw is None else _parsed(self.yaw)
        predictor = load_predictor(name, self.threads, self.input_spec)
        if self.margin is not None:
            predictor = with_margin(predictor, self.margin)
        with progress_bar("sampling meshes") as progress:
            evaluated = open_evaluation_set(predictor, data, self.split, progress)
        # Written first, so that an output folder that can not be written is reported at once.
        how = {"corrupt": True} if self.corrupt else {"yaw_deg": yaws}
        shown = {"margin": predictor.input_spec.margin}
        config = {"data": str(data), "split": self.split, **shown, **how}
        write_json(self.out / "evaluation.json", config)
        write_config(self.out, self, "evaluate")
        if self.corrupt:
            return self._corrupt(predictor, evaluated)
        with progress_bar("objects") as progress:
            sweep = sweep_yaw(predictor, evaluated.objects, yaws, progress)
        metrics = {**self._head(predictor, evaluated), **sweep.to_dict()}
        if self.split == "validation":
            metrics |= _choices(sweep, predictor, evaluated.objects)
        write_json(self.out / "metrics.json", metrics)
        _print(metrics, self.json, _readable(metrics, self.out))
        self._draw(sweep, evaluated.objects)
        return 0

    def _shards(self) -> int:
        from circumspect.cli.commands.evaluate_shards import evaluate_shards

        if len(self.data) != 1:
            raise InputError(f"--data: one set at a time, not {len(self.data)}")
        given = given_flags(
            self, "yaw", "yaw_count", "corrupt", "margin", "scale", "threads", "input_spec"
        )
        if given:
            raise InputError(f"the grids of shards are made already; leave {given[0]} out")
        name = self.model or MODELNET10
        write_config(self.out, self, "evaluate")
        with opened_pool(self.workers, self.cluster) as pool:
            return evaluate_shards(
                self._model_seen(),
                _identity(name),
                seen_from(self.cluster, self.data[0]),
                self.split,
                self.out,
                pool,
                self.json,
            )

    def _model_seen(self) -> str:
        from circumspect.classification.shipped import shipped_name

        name = self.model or MODELNET10
        return name if shipped_name(name) is not None else seen_from(self.cluster, name)

    def _real_objects(self, paths: Sequence[Path]) -> int:
        from circumspect.evaluation.predictor import load_predictor

        if given := given_flags(self, "split", "yaw", "yaw_count", "corrupt", "margin"):
            raise InputError(f"real objects are classified as they are; leave {given[0]} out")
        name = self.model or ROBOT
        predictor = load_predictor(name, self.threads, self.input_spec)
        return evaluate_crops(
            predictor,
            {**_identity(name), **_described(predictor)},
            paths,
            self.out,
            scale=self.scale,
            as_json=self.json,
            claimed=lambda: write_config(self.out, self, "evaluate"),
        )

    def _head(self, predictor: Predictor, evaluated: EvaluationSet) -> dict[str, Any]:
        return {
            "circumspect": __version__,
            **_identity(self.model or MODELNET10),
            **_described(predictor),
            "split": self.split,
            "data": evaluated.objects.digest,
            "seen_in_training": evaluated.seen,
            "margin": predictor.input_spec.margin,
        }

    def _corrupt(self, predictor: Predictor, evaluated: EvaluationSet) -> int:
        from circumspect.cli.progress import progress_bar
        from circumspect.evaluation.robustness import measure_robustness
        from circumspect.storage import write_json

        with progress_bar("corruptions") as progress:
            found = measure_robustness(predictor, evaluated.objects, progress=progress)
        head, count = self._head(predictor, evaluated), len(evaluated.objects)
        metrics = {**head, "objects": count, **found.to_dict()}
        write_json(self.out / "robustness.json", metrics)
        _print(metrics, self.json, _robust(metrics, self.out))
        return 0

    def _draw(self, sweep: YawSweep, objects: ObjectSet) -> None:
        from circumspect.evaluation.figures import draw_all

        try:
            draw_all(sweep, objects, self.out)
        except MissingExtraError as error:
            say(f"no figures: {error}")


def _identity(model: str) -> dict[str, str]:
    """Name and SHA-256 of the evaluated network, without local folders."""
    from circumspect.classification.shipped import model_path, shipped_name
    from circumspect.evaluation.predictor import checkpoint_path

    content = checkpoint_path(model_path(model)).read_bytes()
    name = shipped_name(model) or Path(model).name
    return {"model": name, "sha256": hashlib.sha256(content).hexdigest()}


def _described(predictor: Predictor) -> dict[str, str]:
    """SHA-256 of the input specification, if a network of another program has one."""
    from circumspect.classification import OnnxClassifier

    if not isinstance(predictor, OnnxClassifier):
        return {}
    sha256 = predictor.description.get("input_spec_sha256")
    return {} if sha256 is None else {"input_spec_sha256": sha256}


def _parsed(text: str) -> list[float]:
    try:
        yaws = [float(word) for word in text.split(",")]
    except ValueError:
        yaws = [math.nan]
    if not all(map(math.isfinite, yaws)):
        raise InputError(f"--yaw '{text}': give degrees such as 0,45,90,135")
    return yaws


def _print(metrics: dict[str, Any], as_json: bool, parts: list[str | Table]) -> None:
    if as_json:
        print(json.dumps(metrics))  # noqa: T201
    else:
        from circumspect.cli.console import show

        show(*parts)


def _readable(metrics: dict[str, Any], out: Path) -> list[str | Table]:
    from circumspect.cli.console import new_table

    accuracy = metrics["accuracy"]
    lines: list[str | Table] = [
        f"{metrics['objects']} objects of {metrics['split']}, {len(accuracy)} yaws"
    ]
    if len(accuracy) <= 8:
        table = new_table([], ["yaw [°]", "accuracy", "mean-class"])
        rows = zip(metrics["yaw_deg"], accuracy, metrics["mean_class_accuracy"], strict=True)
        for yaw, a, m in rows:
            table.add_row(f"{yaw:.2f}", f"{a:.4f}", f"{m:.4f}")
        lines.append(table)
    lines.append(
        f"accuracy worst {metrics['worst']:.4f}, best {max(accuracy):.4f}, "
        f"spread {metrics['spread']:.4f}; {100 * metrics['flip_rate']:.1f} % flip"
    )
    lines.append(f"expected calibration error {metrics['expected_calibration_error']:.4f}")
    if "fitted_temperature" in metrics:
        lines.append(f"best temperature {metrics['fitted_temperature']:.3f}")
    if "unknown_beyond" in metrics:
        lines.append(
            f"95 % of the objects lie within {metrics['unknown_beyond']:.3f} of a training object"
        )
    lines += _seen(metrics)
    lines.append(f"metrics and figures: {printable(str(out))}")
    return lines


def _choices(sweep: YawSweep, predictor: TrainedPredictor, objects: ObjectSet) -> dict[str, float]:
    """Values chosen on validation: temperature, and maximum distance of known objects."""
    from circumspect.classification import OnnxClassifier
    from circumspect.evaluation.calibration import fitted_temperature, known_within
    from circumspect.evaluation.distances import nearest_distances

    chosen: dict[str, float] = {}
    # No temperature is best if all of a few objects are classified correctly.
    with suppress(InputError):
        # The probabilities are of logits already divided by the temperature of the predictor.
        chosen["fitted_temperature"] = predictor.temperature * fitted_temperature(*sweep.flat)
    if isinstance(predictor, OnnxClassifier) and predictor.gives_distances:
        found = nearest_distances(predictor, objects, sweep.yaw_deg[:1].tolist())
        chosen["unknown_beyond"] = known_within(found[0])
    return chosen


def _robust(metrics: dict[str, Any], out: Path) -> list[str | Table]:
    from circumspect.cli.console import new_table

    table = new_table(["severity"], [*map(str, range(1, 6)), "mean"])
    for kind, row in metrics["accuracy"].items():
        table.add_row(kind, *(f"{value:.3f}" for value in (*row, sum(row) / len(row))))
    return [
        f"{metrics['objects']} objects of {metrics['split']}; accuracy {metrics['clean']:.3f}, "
        f"corrupted {metrics['mean']:.3f} on average",
        table,
        *_seen(metrics),
        f"metrics: {printable(str(out))}",
    ]


def _seen(metrics: dict[str, Any]) -> list[str]:
    if not metrics["seen_in_training"]:
        return []
    return ["the network was trained on objects of this set: do not quote these figures"]
