"""What a run's folder belongs to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from circumspect.classification import InputRecipe
from circumspect.datasets import ObjectSet
from circumspect.errors import InputError
from circumspect.storage import write_json
from circumspect.training.settings import TrainingSettings

CONFIG = "config.json"


def run_config(
    settings: TrainingSettings, recipe: InputRecipe, objects: ObjectSet
) -> dict[str, Any]:
    """All that determines a run, as JSON types."""
    document = {"settings": settings.to_dict(), "grid": recipe.to_dict(), "data": objects.digest}
    return json.loads(json.dumps(document))


def claim_folder(folder: Path, config: dict[str, Any], begun: bool) -> None:
    """Write the config, or check that the run already there has the same.

    Args:
        folder: Of the run.
        config: From `run_config`.
        begun: The folder holds the state of a run; a config without one is replaced.

    Raises:
        InputError: The run there has other settings.
        OutputError: The folder can not be written.
    """
    path = folder / CONFIG
    if begun and _read(path) != config:
        raise InputError(f"{folder}: holds a run with other settings; choose another --out")
    write_json(path, config)


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
