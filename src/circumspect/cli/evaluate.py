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
from circumspect.cli.evaluate_crops import are_crops, evaluate_crops
from circumspect.cli.given_flags import given_flags
from circumspect.cli.job_pool import opened_pool, seen_from
from circumspect.cli.model_flag import MODELNET10, ROBOT
from circumspect.cli.net_flag import NetFlag, name_net
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.datasets import ObjectSet
    from circumspect.evaluation.evaluation_set import EvaluationSet
    from circumspect.evaluation.predictor import Predictor, TrainedPredictor
    from circumspect.evaluation.yaw_sweep import YawSweep

YAWS = 64
"""Without a flag."""


@dataclass(frozen=True)
class Evaluate:
    """Accuracy over many yaws, or on labelled real objects.

    $ circumspect evaluate --data ModelNet10 --split test --yaw-count 64 --out eval
    $ circumspect evaluate --model runs/train-planes --data ModelNet10 --yaw 0,45
    $ circumspect evaluate --data ModelNet10 --split test --corrupt --out robustness
    $ circumspect evaluate --data objects.npz --out real
    $ circumspect evaluate --model runs/train-planes --data shards --split test
    """

    data: Annotated[tuple[str, ...], tyro.conf.arg(metavar="PATH|URL")]
    """Folder with point packs, ModelNet10's folder of OFF files, one of own classes as
    <class>/{train,test}/* in any readable format, or a set that `gather` made; the folder or URL of
    shards that `data convert` made, which are not turned; or files of labelled real objects, which
    are not turned: docs/real-objects.md has their layout."""
    model: Annotated[str | None, tyro.conf.arg(metavar="NAME|FILE")] = None
    """A shipped classifier (`circumspect models` lists them), an ONNX file, a checkpoint or a run's
    folder; by default modelnet10, that of the paper's protocol, and robot on real objects."""
    input_spec: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """TOML or JSON that describes an ONNX file of another program (docs/own-network.md); by
    default NAME.input.toml or NAME.input.json beside NAME.onnx."""
    net: NetFlag = None
    """Of a checkpoint whose network is not installed: the network's code."""
    split: Literal["validation", "test", "train"] = "validation"
    """Choices are made on validation; test is for reports."""
    yaw: Annotated[str | None, tyro.conf.arg(metavar="DEG,DEG,...")] = None
    """Angles in degrees, such as 0,45,90,135."""
    yaw_count: int | None = None
    """This many angles over the turn, each at another fraction of a cell, without --yaw; 64 by
    default."""
    corrupt: bool = False
    """Instead of turning objects, corrupt them in twelve ways and five severities each."""
    margin: float | None = None
    """Show objects in a grid this many times as large as the smallest one, in place of the
    classifier's own margin."""
    scale: Literal["metric", "unknown"] = "metric"
    """Of real objects: unknown withholds from the classifier that coordinates are metres."""
    out: Path = Path("evaluation")
    """Folder for metrics.json and figures."""
    json: bool = False
    """Print the metrics as JSON and nothing else on standard output."""
    threads: int = 0
    """Threads of ONNX Runtime; 0 means all cores."""
    workers: int | None = None
    """Of shards: processes; one a core without it."""
    cluster: str | None = None
    """Of shards: work on a Ray cluster, "auto" or HOST:PORT, whose nodes see the shards and the
    classifier under the same paths."""

    def run(self) -> int:
        """Evaluate, write and tell."""
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
        # First of all, so that a folder that can not be written is found out before the work.
        how = {"corrupt": True} if self.corrupt else {"yaw_deg": yaws}
        shown = {"margin": predictor.recipe.margin}
        config = {"data": str(data), "split": self.split, **shown, **how}
        write_json(self.out / "evaluation.json", config)
        if self.corrupt:
            return self._corrupt(predictor, evaluated)
        with progress_bar("objects") as progress:
            sweep = sweep_yaw(predictor, evaluated.objects, yaws, progress)
        metrics = {**self._head(predictor, evaluated), **sweep.metrics()}
        if self.split == "validation":
            metrics |= _choices(sweep, predictor, evaluated.objects)
        write_json(self.out / "metrics.json", metrics)
        print(json.dumps(metrics) if self.json else _readable(metrics, self.out))  # noqa: T201
        self._draw(sweep, evaluated.objects)
        return 0

    def _shards(self) -> int:
        from circumspect.cli.evaluate_shards import evaluate_shards

        if len(self.data) != 1:
            raise InputError(f"--data: one set at a time, not {len(self.data)}")
        given = given_flags(
            self, "yaw", "yaw_count", "corrupt", "margin", "scale", "threads", "input_spec"
        )
        if given:
            raise InputError(f"the grids of shards are made already; leave {given[0]} out")
        name = self.model or MODELNET10
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
        )

    def _head(self, predictor: Predictor, evaluated: EvaluationSet) -> dict[str, Any]:
        return {
            "circumspect": __version__,
            **_identity(self.model or MODELNET10),
            **_described(predictor),
            "split": self.split,
            "data": evaluated.objects.digest,
            "seen_in_training": evaluated.seen,
            "margin": predictor.recipe.margin,
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
        print(json.dumps(metrics) if self.json else _robust(metrics, self.out))  # noqa: T201
        return 0

    def _draw(self, sweep: YawSweep, objects: ObjectSet) -> None:
        from circumspect.evaluation.figures import draw_all

        try:
            draw_all(sweep, objects, self.out)
        except MissingExtraError as error:
            say(f"no figures: {error}")


def _identity(model: str) -> dict[str, str]:
    """Which network was evaluated: its name, but no folder of this machine, and its hash."""
    from circumspect.classification.shipped import model_path, shipped_name
    from circumspect.evaluation.predictor import checkpoint_path

    content = checkpoint_path(model_path(model)).read_bytes()
    name = shipped_name(model) or Path(model).name
    return {"model": name, "sha256": hashlib.sha256(content).hexdigest()}


def _described(predictor: Predictor) -> dict[str, str]:
    """The hash of the input specification, where a network of another program has one."""
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


def _readable(metrics: dict[str, Any], out: Path) -> str:
    accuracy = metrics["accuracy"]
    lines = [f"{metrics['objects']} objects of {metrics['split']}, {len(accuracy)} yaws"]
    if len(accuracy) <= 8:
        rows = zip(metrics["yaw_deg"], accuracy, metrics["mean_class_accuracy"], strict=True)
        lines.append("  yaw [deg]   accuracy   mean-class")
        lines += [f"  {yaw:9.2f}   {a:8.4f}   {m:10.4f}" for yaw, a, m in rows]
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
    return "\n".join(lines)


def _choices(sweep: YawSweep, predictor: TrainedPredictor, objects: ObjectSet) -> dict[str, float]:
    """What is chosen on validation: temperature, and how far a known object may be."""
    from circumspect.classification import OnnxClassifier
    from circumspect.evaluation.calibration import fitted_temperature, known_within
    from circumspect.evaluation.distances import nearest_distances

    chosen: dict[str, float] = {}
    # None is best of a handful of objects that are all named rightly.
    with suppress(InputError):
        # The probabilities are those of logits that were divided by a temperature already.
        chosen["fitted_temperature"] = predictor.temperature * fitted_temperature(*sweep.flat)
    if isinstance(predictor, OnnxClassifier) and predictor.gives_distances:
        found = nearest_distances(predictor, objects, sweep.yaw_deg[:1].tolist())
        chosen["unknown_beyond"] = known_within(found[0])
    return chosen


def _robust(metrics: dict[str, Any], out: Path) -> str:
    lines = [
        f"{metrics['objects']} objects of {metrics['split']}; accuracy {metrics['clean']:.3f}, "
        f"corrupted {metrics['mean']:.3f} on average",
        f"{'severity':14}" + "".join(f"{severity:8}" for severity in range(1, 6)) + "    mean",
    ]
    for kind, row in metrics["accuracy"].items():
        cells = "".join(f"{value:8.3f}" for value in (*row, sum(row) / len(row)))
        lines.append(f"{kind:14}{cells}")
    lines += _seen(metrics)
    lines.append(f"metrics: {printable(str(out))}")
    return "\n".join(lines)


def _seen(metrics: dict[str, Any]) -> list[str]:
    if not metrics["seen_in_training"]:
        return []
    return ["the network was trained on objects of this set: do not quote these figures"]
