"""A classifier or a checkpoint as one function from inputs to probabilities."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from circumspect.classification import Classifier, InputSpec
from circumspect.classification.context import contexts_of
from circumspect.classification.shipped import shipped_name
from circumspect.datasets import ObjectSet
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.errors import MissingExtraError, WeightsError

CHECKPOINT_SUFFIX = ".safetensors"
BATCH = 64


class Predictor(Protocol):
    """Classifies inputs of its input specification."""

    @property
    def classes(self) -> tuple[str, ...]:
        """Class names in the order of the outputs."""
        ...

    @property
    def input_spec(self) -> InputSpec:
        """How clouds become inputs."""
        ...

    def probabilities(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """(n, views, *input_shape) inputs to (n, c) probabilities.

        Without contexts (n, 6) the scale of the objects counts as unknown.
        """
        ...


class TrainedPredictor(Predictor, Protocol):
    """A predictor with a record of its training, as loaded weights have."""

    @property
    def temperature(self) -> float:
        """Divisor of the logits."""
        ...

    @property
    def training(self) -> Mapping[str, Any]:
        """How it was trained, see `Checkpoint`; empty where unknown."""
        ...


def check_classes(predictor: Predictor, objects: ObjectSet) -> None:
    """Check that weights and a data set have the same classes.

    Raises:
        WeightsError: The weights know other classes than the set.
    """
    if predictor.classes != objects.classes:
        raise WeightsError(
            f"the weights know {', '.join(predictor.classes)}, but the data set has "
            f"{', '.join(objects.classes)}; evaluate on a set of the same classes"
        )


def checkpoint_path(weights: Path) -> Path:
    """The file of a path: itself, or the best checkpoint in a run's folder.

    Raises:
        WeightsError: A folder without one.
    """
    if not weights.is_dir():
        return weights
    best = weights / f"best{CHECKPOINT_SUFFIX}"
    if not best.exists():
        raise WeightsError(f"{weights}: holds no {best.name}; train first")
    return best


def load_predictor(
    model: str | os.PathLike[str] | None = None,
    threads: int = 0,
    input_spec: str | os.PathLike[str] | None = None,
) -> TrainedPredictor:
    """Load an ONNX classifier or a checkpoint of a training run.

    A checkpoint runs on the GPU if there is one, as in training.

    Args:
        model: The name of a shipped classifier or an ONNX file, as `Classifier.load` takes them; a
            checkpoint; or the folder of a run.
        threads: Threads of ONNX Runtime; 0 means all cores.
        input_spec: File for an ONNX network of another program, see `Classifier.load`.

    Raises:
        WeightsError: No classifier has this name, or the file is missing, broken, or of another
            program.
        MissingExtraError: A checkpoint needs torch.
    """
    if not model or shipped_name(model) is not None:
        return Classifier.load(model, threads, input_spec)
    weights = checkpoint_path(Path(model))
    if weights.suffix != CHECKPOINT_SUFFIX:
        return Classifier.load(model, threads, input_spec)
    if input_spec is not None:
        raise WeightsError(
            f"{input_spec}: {weights} is a checkpoint and needs no input specification"
        )
    return _checkpoint_predictor(weights)


def _checkpoint_predictor(weights: Path) -> TrainedPredictor:
    """A checkpoint as a predictor.

    Raises:
        WeightsError: The file is broken.
        MissingExtraError: torch is not installed.
    """
    try:
        import torch
    except ImportError as error:
        raise MissingExtraError("torch", "train") from error
    from circumspect.nets import Checkpoint
    from circumspect.nets.state_channels import state_channels

    checkpoint = Checkpoint.load(weights)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    if device.type == "cuda":
        # As on a CPU; TF32 would round convolutions.
        torch.backends.cudnn.allow_tf32 = False
    net = checkpoint.build().to(device)

    input_spec, other = checkpoint.input_spec, OTHER in checkpoint.classes
    classes = tuple(name for name in checkpoint.classes if name != OTHER)

    def logits(inputs: NDArray[Any], contexts: NDArray[np.float32] | None) -> torch.Tensor:
        shown = [torch.from_numpy(inputs).to(device)]
        if contexts is not None:
            shown = [state_channels(shown[0]), torch.from_numpy(contexts).to(device)]
        return net(shown[0].float(), *shown[1:]).cpu()

    def probabilities(
        inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        count, views = inputs.shape[:2]
        contexts = contexts_of(input_spec, inputs, contexts)
        flat = inputs.reshape(count * views, *inputs.shape[2:])
        repeated = None if contexts is None else np.repeat(contexts, views, axis=0)
        parts = [slice(start, start + BATCH) for start in range(0, len(flat), BATCH)]
        with torch.inference_mode():
            found = [logits(flat[p], None if repeated is None else repeated[p]) for p in parts]
        mean = torch.cat(found).double().view(count, views, -1).mean(1)
        # The last output of a network with a class of other things is dropped.
        return (mean[:, :-1] if other else mean).softmax(1).numpy()

    return _Predictor(classes, input_spec, 1.0, checkpoint.training, probabilities)


def with_margin(predictor: TrainedPredictor, margin: float) -> TrainedPredictor:
    """The same network with another margin of its inputs.

    Raises:
        InputError: The margin is out of range.
    """
    return _Predictor(
        predictor.classes, predictor.input_spec.with_margin(margin), predictor.temperature,
        predictor.training, predictor.probabilities,
    )  # fmt: skip


class _Function(Protocol):
    def __call__(
        self, inputs: NDArray[Any], contexts: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]: ...


@dataclass(frozen=True)
class _Predictor:
    classes: tuple[str, ...]
    input_spec: InputSpec
    temperature: float
    training: Mapping[str, Any]
    probabilities: _Function
