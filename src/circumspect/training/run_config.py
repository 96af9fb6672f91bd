"""What a run's folder belongs to."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from circumspect.classification import InputRecipe
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.errors import InputError, OutputError
from circumspect.storage import require_no_strangers, write_json
from circumspect.training.config_differences import config_differences
from circumspect.training.run_log import LOG, logged_epochs
from circumspect.training.settings import TrainingSettings

CONFIG = "config.json"
STATE = "state.safetensors"
BEST = "best.safetensors"
MADE_OF = "made_of.json"
"""Beside a run that an experiment finished, and whose state it then removed."""


def run_config(
    settings: TrainingSettings,
    recipe: InputRecipe,
    digest: str,
    catalogues: Sequence[LabelledSurfaces] = (),
) -> dict[str, Any]:
    """All that determines a run, as JSON types.

    Args:
        settings: Of the run.
        recipe: What the network is shown.
        digest: A hash of the objects.
        catalogues: Further objects.
    """
    document = {"settings": settings.to_dict(), "grid": recipe.to_dict(), "data": digest}
    if catalogues:
        document["catalogues"] = [catalogue.digest for catalogue in catalogues]
    return json.loads(json.dumps(document))


def claim_folder(folder: Path, config: dict[str, Any]) -> None:
    """Write the config, or check that the run already there can go on with it.

    A run that was interrupted before its first state has nothing to lose and is replaced.

    Args:
        folder: Of the run.
        config: From `run_config`.

    Raises:
        InputError: The run there has other settings, or is finished and has no state to go on from.
        OutputError: The folder can not be written, or holds files of something else.
    """
    require_no_strangers(folder, (STATE, BEST, MADE_OF, LOG), (CONFIG,))
    path = folder / CONFIG
    other = config_differences(_stored(path), config) if path.exists() else ""
    if (folder / STATE).exists():
        if other:
            raise InputError(f"{folder}: holds a run with other {other}; choose another --out")
    elif _is_finished(folder, same=not other):
        raise InputError(
            f"{folder}: holds a run's network without the state to go on from; choose another --out"
        )
    write_json(path, config)


def _is_finished(folder: Path, same: bool) -> bool:
    """Of a run without a state, whether it has more to lose than its first epoch."""
    if (folder / MADE_OF).exists():
        return True
    # The first epoch's network is written before the first state, between which it may have ended.
    return (folder / BEST).exists() and not (same and logged_epochs(folder) == 1)


def _stored(path: Path) -> dict[str, Any]:
    """The config of an earlier run."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or not {"settings", "grid", "data"} <= found.keys():
        raise OutputError(f"{path}: is of no training and would be replaced; take another folder")
    return found
