"""Accuracy over the yaw of objects."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import InputSpec
from circumspect.datasets import ObjectSet
from circumspect.errors import GeometryError, InputError
from circumspect.evaluation.accuracy import confusion_matrix, mean_class_accuracy
from circumspect.evaluation.calibration import reliability
from circumspect.evaluation.predictor import Predictor, check_classes
from circumspect.figure_canvas import ACCENT, axes_or_new
from circumspect.geometry.formats.npy_stream import NPZ_ERRORS, error_text
from circumspect.storage import atomic_open

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINE_FROM = 12
"""With fewer yaws a line between them would suggest what was not measured."""
MAX_YAWS = 3600
"""Steps of a tenth of a degree; the inputs of an object at all of them are in memory at once."""


@dataclass(frozen=True, eq=False)
class YawSweep:
    """Answers to n objects at y yaws.

    Attributes:
        yaw_deg: (y,) angles [deg].
        probabilities: (y, n, c).
        labels: (n,) true classes.
        classes: The c class names.
        milliseconds: Stage to median time per object and yaw [ms].
    """

    yaw_deg: NDArray[np.float64]
    probabilities: NDArray[np.float64]
    labels: NDArray[np.int64]
    classes: tuple[str, ...]
    milliseconds: dict[str, float]

    @property
    def answers(self) -> NDArray[np.int64]:
        """(y, n) predicted classes."""
        return self.probabilities.argmax(axis=2)

    @property
    def accuracy(self) -> NDArray[np.float64]:
        """(y,) fraction of objects classified correctly."""
        return (self.answers == self.labels).mean(axis=1)

    @property
    def flip_rate(self) -> float:
        """Fraction of objects whose label differs between yaws."""
        return float((self.answers != self.answers[0]).any(axis=0).mean())

    @property
    def summary(self) -> dict[str, float]:
        """Mean and worst accuracy over the yaws, their spread, and the flip rate."""
        accuracy = self.accuracy
        return {
            "mean": float(accuracy.mean()),
            "worst": float(accuracy.min()),
            "spread": float(np.ptp(accuracy)),
            "flip_rate": self.flip_rate,
        }

    @property
    def confusion(self) -> NDArray[np.int64]:
        """(c, c) counts over all yaws; row is the true class."""
        return confusion_matrix(self.flat[1], self.answers.reshape(-1), len(self.classes))

    @property
    def flat(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(y n, c) probabilities and (y n,) labels of all answers."""
        labels = np.broadcast_to(self.labels, self.answers.shape).reshape(-1)
        return self.probabilities.reshape(-1, len(self.classes)), labels

    def plot(self, axes: Axes | None = None, label: str | None = None, **line: Any) -> Axes:
        """Draw accuracy over the yaw of the object; several sweeps may share axes.

        Args:
            axes: Where to draw; None for a new figure.
            label: Name in a legend.
            line: Colour and style, as matplotlib names them.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        axes = axes_or_new(axes, (9.0, 5.0))
        draw_accuracy_over_yaw(axes, self.yaw_deg, self.accuracy, label, **line)
        return axes

    def save(self, path: Path) -> None:
        """Write all of it as NPZ.

        Raises:
            OutputError: It cannot be written.
        """
        with atomic_open(path, "wb") as stream:
            np.savez_compressed(
                stream,
                yaw_deg=self.yaw_deg,
                probabilities=self.probabilities.astype(np.float32),
                labels=self.labels,
                classes=np.array(self.classes),
                milliseconds=np.array(json.dumps(self.milliseconds)),
            )

    @classmethod
    def load(cls, path: Path) -> YawSweep:
        """Read what `save` wrote.

        Raises:
            InputError: The file is missing or broken.
        """
        try:
            # NumPy leaves a broken file open if it opened it itself.
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
                return cls(
                    stored["yaw_deg"],
                    stored["probabilities"].astype(np.float64),
                    stored["labels"],
                    tuple(str(name) for name in stored["classes"]),
                    json.loads(str(stored["milliseconds"])),
                )
        except (OSError, TypeError, *NPZ_ERRORS) as error:
            raise InputError(f"{path}: not a yaw sweep ({error_text(error)})") from error

    def to_dict(self) -> dict[str, Any]:
        """Content of `metrics.json`."""
        correct = self.answers == self.labels
        summary = self.summary
        mean_class = [mean_class_accuracy(row, self.labels, len(self.classes)) for row in correct]
        return {
            "yaw_deg": self.yaw_deg.tolist(),
            "accuracy": self.accuracy.tolist(),
            "mean_class_accuracy": mean_class,
            "worst": summary["worst"],
            "spread": summary["spread"],
            "flip_rate": summary["flip_rate"],
            "expected_calibration_error": reliability(*self.flat).expected_error,
            "confusion": self.confusion.tolist(),
            "classes": list(self.classes),
            "objects": len(self.labels),
            "milliseconds": self.milliseconds,
        }


def draw_accuracy_over_yaw(
    axes: Axes,
    yaw_deg: NDArray[np.floating],
    accuracy: NDArray[np.floating],
    label: str | None = None,
    **line: Any,
) -> None:
    """Accuracy from 0 to 100 % over the full turn, in the one style of all figures.

    Args:
        axes: Where to draw; may hold other lines already.
        yaw_deg: (y,) angles [deg]; fewer than `LINE_FROM` are not joined by a line.
        accuracy: (y,) shares, 0 to 1.
        label: Name in a legend; the worst accuracy is added.
        line: Colour and style, as matplotlib names them.
    """
    order = np.argsort(yaw_deg)
    joined = {"marker": "."} if len(yaw_deg) >= LINE_FROM else {"marker": "o", "linestyle": ""}
    if label is not None:
        label = f"{label}: worst {100 * accuracy.min():.1f} %"
    looks = {"color": ACCENT, **line, **joined, "label": label}
    axes.plot(np.asarray(yaw_deg)[order], 100 * np.asarray(accuracy)[order], **looks)
    axes.set(xlabel="yaw of the object [°]", ylabel="accuracy [%]", xlim=(0, 360), ylim=(0, 100))
    axes.set_xticks(range(0, 361, 45))
    axes.grid(alpha=0.3)


def spread_yaws(count: int) -> list[float]:
    """`count` angles over the full turn [deg], no two at the same fraction of an azimuth cell.

    Even steps would meet few fractions: 64 of them fall only on whole and half cells of 32. So each
    angle has another offset within its step, by the golden ratio; the first is 0.

    Raises:
        InputError: Fewer than one, or more than `MAX_YAWS`.
    """
    if count < 1:
        raise InputError(f"at least one yaw is needed, not {count}")
    if count > MAX_YAWS:
        raise InputError(f"at most {MAX_YAWS} yaws can be spread over the turn, not {count}")
    steps = np.arange(count)
    golden = (np.sqrt(5) - 1) / 2
    return ((steps + (steps * golden) % 1.0) * 360.0 / count).tolist()


def sweep_yaw(
    predictor: Predictor,
    objects: ObjectSet,
    yaw_deg: Sequence[float],
    progress: Callable[[int, int], None] | None = None,
) -> YawSweep:
    """Turn the points of every object, grid them again, and classify them.

    Args:
        predictor: The classifier.
        objects: The set.
        yaw_deg: y angles [deg].
        progress: Called with (done, all) objects.

    Raises:
        WeightsError: The weights know other classes than the set.
        InputError: No objects or no yaws.
    """
    check_classes(predictor, objects)
    if not len(objects) or not len(yaw_deg):
        raise InputError("nothing to evaluate: no objects or no yaws")
    probabilities = np.empty((len(yaw_deg), len(objects), len(objects.classes)))
    times: dict[str, list[float]] = {"grid": [], "classify": []}
    for index, (inputs, seconds) in enumerate(_made(predictor, objects, np.deg2rad(yaw_deg))):
        start = time.perf_counter()
        probabilities[:, index] = predictor.probabilities(inputs)
        times["grid"].append(seconds / len(yaw_deg))
        times["classify"].append((time.perf_counter() - start) / len(yaw_deg))
        if progress:
            progress(index + 1, len(objects))
    return YawSweep(
        np.asarray(yaw_deg, np.float64),
        probabilities,
        objects.labels,
        objects.classes,
        {name: 1e3 * float(np.median(values)) for name, values in times.items()},
    )


def inputs_of(
    input_spec: InputSpec, objects: ObjectSet, index: int, yaws: Sequence[float]
) -> NDArray[Any]:
    """The inputs for one object of a set, as `InputSpec.inputs`.

    Raises:
        InputError: The object spans no shape; the message names it.
    """
    try:
        return input_spec.inputs(objects.cloud(index), yaws)
    except GeometryError as error:
        raise InputError(f"{objects.names[index]}: {error}") from error


def _made(
    predictor: Predictor, objects: ObjectSet, yaws: NDArray[np.float64]
) -> Iterator[tuple[NDArray[Any], float]]:
    """The inputs of each object and their time [s], computed one object ahead."""

    def made(index: int) -> tuple[NDArray[Any], float]:
        start = time.perf_counter()
        inputs = inputs_of(predictor.input_spec, objects, index, yaws.tolist())
        return inputs, time.perf_counter() - start

    with ThreadPoolExecutor(1) as pool:
        ahead = pool.submit(made, 0)
        for index in range(len(objects)):
            current = ahead.result()
            if index + 1 < len(objects):
                ahead = pool.submit(made, index + 1)
            yield current
