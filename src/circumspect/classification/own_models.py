"""The user's own classifiers by name: those that `circumspect teach` wrote."""

from __future__ import annotations

import os
import re
from pathlib import Path

OWN_NAME = re.compile(r"[A-Za-z0-9][\w-]{0,63}")


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
    """The file of an own classifier that is asked for by its name; None for anything else.

    Args:
        model: As `Classifier.load` takes it. A path object is always a file.
    """
    if not isinstance(model, str) or not OWN_NAME.fullmatch(model):
        return None
    file = own_model_path(model)
    return file if file.is_file() else None
