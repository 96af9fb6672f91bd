"""The shipped classifiers by name."""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from circumspect.errors import WeightsError

WEIGHTS = "weights"
"""The folder of the package that holds them."""
ROBOT = "robot"
MODELNET10 = "modelnet10"
DEFAULT = ROBOT
"""The default classifier."""
OWN_NAME = re.compile(r"[A-Za-z0-9][\w-]{0,63}")


@dataclass(frozen=True)
class ShippedClassifier:
    """A classifier that comes with the package.

    Attributes:
        name: Its name for `Classifier.load` and the flag `--model`.
        summary: Its purpose, in one line.
        training_data: Its training data, in words.
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
"""The shipped classifiers by name; the default comes first."""


def shipped_name(model: str | os.PathLike[str] | None) -> str | None:
    """The shipped classifier for a model argument.

    A name takes precedence over a file of the same name in the current folder: `./robot` is the
    file. A path object is always a file.

    Args:
        model: A name, a file, or None for the default.

    Returns:
        Its name; None for a file.
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
    """The file of a shipped or an own classifier; it need not exist.

    Args:
        model: As `Classifier.load` takes it.
    """
    name = shipped_name(model)
    if name is not None:
        return shipped_path(name)
    return own_model(model) or Path(model or "")


def unknown_model(model: str | os.PathLike[str]) -> WeightsError:
    """The error for an argument that is no shipped classifier and no file."""
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


def own_models_folder() -> Path:
    """`$CIRCUMSPECT_MODELS`, or a folder among the user's application data."""
    if (given := os.environ.get("CIRCUMSPECT_MODELS")) is not None:
        return Path(given)
    home = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(home) / "circumspect" / "models"


def own_model_path(name: str) -> Path:
    """The file of a name; it need not exist."""
    return own_models_folder() / f"{name}.json"


def own_model_names() -> tuple[str, ...]:
    """The names of all, in alphabetical order."""
    files = own_models_folder().glob("*.json")
    return tuple(sorted(file.stem for file in files if OWN_NAME.fullmatch(file.stem)))


def own_model(model: str | os.PathLike[str] | None) -> Path | None:
    """The file of an own classifier by its name; None for anything else.

    Args:
        model: As `Classifier.load` takes it. A path object is always a file.
    """
    if not isinstance(model, str) or not OWN_NAME.fullmatch(model):
        return None
    file = own_model_path(model)
    return file if file.is_file() else None
