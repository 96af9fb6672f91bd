"""The classifiers that come with the package, by name."""

from __future__ import annotations

import difflib
import os
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from circumspect.classification.own_models import own_model, own_model_names
from circumspect.errors import WeightsError

WEIGHTS = "weights"
"""The folder of the package that holds them."""
ROBOT = "robot"
MODELNET10 = "modelnet10"
DEFAULT = ROBOT
"""The classifier that is loaded where none is named."""


@dataclass(frozen=True)
class ShippedClassifier:
    """A classifier that comes with the package.

    Attributes:
        name: What `Classifier.load` and the flag `--model` call it.
        summary: What it is for, in one line.
        training_data: What it was trained on, in words.
    """

    name: str
    summary: str
    training_data: str

    @property
    def path(self) -> Path:
        """The ONNX file."""
        folder = resources.files("circumspect.classification").joinpath(WEIGHTS)
        return Path(str(folder.joinpath(f"{self.name}.onnx")))


SHIPPED = {
    one.name: one
    for one in (
        ShippedClassifier(
            ROBOT,
            "for robots and your own files: partial, metric and real views",
            "furniture as a robot sees it: partial views, in metres",
        ),
        ShippedClassifier(
            MODELNET10,
            "the paper's protocol: complete models, any scale, trained at 0° only",
            "ModelNet10's training split, at 0° only",
        ),
    )
}
"""All of them by name; the default comes first."""


def shipped_name(model: str | os.PathLike[str] | None) -> str | None:
    """The shipped classifier that somebody asks for.

    A name goes before a file of the same name in the current folder: `./robot` is the file. A path
    object is always a file.

    Args:
        model: A name, a file, or None for the default.

    Returns:
        Its name; None where a file is asked for.
    """
    if model is None:
        return DEFAULT
    return model if isinstance(model, str) and model in SHIPPED else None


def shipped_path(name: str) -> Path:
    """The ONNX file of a shipped classifier.

    Raises:
        WeightsError: No classifier has this name.
    """
    if name not in SHIPPED:
        raise unknown_model(name)
    return SHIPPED[name].path


def model_path(model: str | os.PathLike[str] | None) -> Path:
    """The file of a shipped classifier or of one's own; it need not exist.

    Args:
        model: As `Classifier.load` takes it.
    """
    name = shipped_name(model)
    if name is not None:
        return shipped_path(name)
    return own_model(model) or Path(model or "")


def unknown_model(model: str | os.PathLike[str]) -> WeightsError:
    """The error for what is neither a shipped classifier nor a file."""
    text = os.fspath(model)
    bare = os.sep not in text
    names = (*SHIPPED, *own_model_names())
    near = difflib.get_close_matches(Path(text).stem.lower(), names, 1) if bare else []
    hint = f"did you mean '{near[0]}'? " if near else ""
    known = f"{hint}shipped: {', '.join(SHIPPED)}"
    if own := own_model_names():
        known += f"; your own: {', '.join(own)}"
    if isinstance(model, str) and bare and not Path(text).suffix:
        return WeightsError(f"no classifier '{text[:80]}'; {known}; or give an ONNX file")
    return WeightsError(f"{text}: no such file; {known}")
