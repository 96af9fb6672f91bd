"""The config in the folder of a run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from circumspect.classification import GridSpec, InputSpec, PointsSpec
from circumspect.classification.input_spec_dict import with_current_names
from circumspect.datasets.labelled_surfaces import LabelledSurfaces
from circumspect.errors import InputError, OutputError
from circumspect.storage import require_no_foreign_files, write_json
from circumspect.training.run_log import LOG, logged_epochs
from circumspect.training.settings import TrainingSettings

CONFIG = "config.json"
STATE = "state.safetensors"
BEST = "best.safetensors"
MADE_OF = "made_of.json"
"""File in a finished run of an experiment, whose state was removed."""
MAX_VALUE_LENGTH = 24
"""Maximum length of values in messages [characters]."""
ADDED = ("margin", "dithered", "visibility", "metric", "scale_required", "farthest_first")
"""Entries of an input specification that the first stored runs lack."""
MAX_DIFFERENCES = 4
"""Maximum number of named differences; further ones are counted."""


def run_config(
    settings: TrainingSettings,
    input_spec: InputSpec,
    digest: str,
    catalogues: Sequence[LabelledSurfaces] = (),
) -> dict[str, Any]:
    """Everything that defines a run, as JSON types.

    Args:
        settings: Settings of the run.
        input_spec: The network's inputs.
        digest: Hash of the objects.
        catalogues: Additional training objects.
    """
    document = {"settings": settings.to_dict(), "grid": input_spec.to_dict(), "data": digest}
    if catalogues:
        document["catalogues"] = [catalogue.digest for catalogue in catalogues]
    return json.loads(json.dumps(document))


def claim_folder(folder: Path, config: dict[str, Any], writes: bool = True) -> None:
    """Check that a run with this config can start or resume in a folder, and write the config.

    A run that was interrupted before its first state is replaced.

    Args:
        folder: Folder of the run.
        config: Config from `run_config`.
        writes: Whether to write; False for all processes of a run except the first.

    Raises:
        InputError: The run in the folder has other settings, or is finished without a state to
            resume from.
        OutputError: The folder cannot be written, or contains foreign files.
    """
    require_no_foreign_files(folder, (STATE, BEST, MADE_OF, LOG), (CONFIG,))
    path = folder / CONFIG
    other = config_differences(_stored(path), config) if path.exists() else ""
    if (folder / STATE).exists():
        if other:
            raise InputError(f"{folder}: holds a run with other {other}; choose another --out")
    elif _is_finished(folder, same=not other):
        raise InputError(
            f"{folder}: holds a run's network without a state to resume from; choose another --out"
        )
    if writes:
        write_json(path, config)


def _is_finished(folder: Path, same: bool) -> bool:
    """Whether a run without a state is finished, or went beyond its first epoch."""
    if (folder / MADE_OF).exists():
        return True
    # The first epoch's network is written before the first state; the run may stop in between.
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


def config_differences(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """Describe differences, such as "settings.epochs (6, not 24)"; empty if there are none.

    Args:
        stored: The config in the folder, JSON types.
        asked: The requested config, JSON types.
    """
    held, wanted = _flat(_completed(stored)), _flat(asked)
    differing = [key for key in {**wanted, **held} if _differ(key, held, wanted)]
    named = [_named(key, held, wanted) for key in differing[:MAX_DIFFERENCES]]
    more = [f"{len(differing) - MAX_DIFFERENCES} more"] if len(differing) > MAX_DIFFERENCES else []
    return ", ".join(named + more)


def _completed(stored: Mapping[str, Any]) -> Mapping[str, Any]:
    """The config with missing settings; their defaults are the earlier behaviour."""
    settings = json.loads(json.dumps(TrainingSettings().to_dict()))
    found = {
        name: stored[name] for name in ("settings", "grid") if isinstance(stored.get(name), dict)
    }
    if "grid" in found:
        found["grid"] = with_current_names(found["grid"])
    points = found.get("grid", {}).get("kind") == "points"
    input_spec = (PointsSpec() if points else GridSpec()).to_dict()
    added = {name: input_spec[name] for name in ADDED if name in input_spec}
    defaults = {"settings": settings, "grid": added}
    return {**stored, **{name: _filled(part, defaults[name]) for name, part in found.items()}}


def _filled(found: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    filled = {**defaults, **found}
    for name, default in defaults.items():
        if isinstance(default, dict) and isinstance(filled[name], dict):
            filled[name] = _filled(filled[name], default)
    return filled


def _flat(document: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """The values by dotted names."""
    flat: dict[str, Any] = {}
    for name, value in document.items():
        inner = isinstance(value, dict) and value
        flat |= _flat(value, f"{above}{name}.") if inner else {f"{above}{name}": value}
    return flat


def _differ(key: str, held: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    return (key in held) != (key in wanted) or held[key] != wanted[key]


def _named(key: str, held: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    if key in held and key in wanted:
        values = json.dumps(held[key]), json.dumps(wanted[key])
        if max(map(len, values)) <= MAX_VALUE_LENGTH:
            return f"{key} ({values[0]}, not {values[1]})"
    return key
