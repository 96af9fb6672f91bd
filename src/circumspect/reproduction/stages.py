"""Stages of an experiment: each is done once, and results of another are never mixed in."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from circumspect import __version__
from circumspect.classification import InputRecipe
from circumspect.datasets import GridCache, ObjectSet
from circumspect.errors import InputError
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.yaw_sweep import YawSweep, sweep_yaw
from circumspect.reproduction.result_form import Form, fits
from circumspect.storage import atomic_open, write_json
from circumspect.training import TrainingSettings, train
from circumspect.training.config_differences import config_differences
from circumspect.training.resume import state_version
from circumspect.training.run_config import BEST, MADE_OF, STATE, run_config
from circumspect.training.train import TrainingObserver

SWEEP = "sweep.npz"
RESULT = "result.json"
VERSION = "circumspect"
"""Key of the version of the package that made a result."""


def trained(
    objects: ObjectSet,
    settings: TrainingSettings,
    recipe: InputRecipe,
    folder: Path,
    observer: TrainingObserver,
    cache: GridCache | None = None,
) -> Path:
    """Train a network, or go on with it, or leave it as it is where it is done.

    Returns:
        The checkpoint of the epoch that is kept.

    Raises:
        InputError: The folder holds another run, one of another version of the package, or one
            whose network is gone.
        OutputError: It can not be written.
        WeightsError: An unfinished run's state is broken.
    """
    made_of = _training_made_of(objects, settings, recipe)
    if not is_done(folder, made_of):
        _require_own_state(folder)
        train(objects, settings, folder, observer, cache, recipe)
        write_json(folder / MADE_OF, made_of)
    elif not (folder / BEST).is_file():
        raise InputError(f"{folder / BEST}: is missing; {_made_anew(folder)}")
    # Hundreds of megabytes that only an unfinished run needs.
    (folder / STATE).unlink(missing_ok=True)
    return folder / BEST


def is_trained(
    objects: ObjectSet, settings: TrainingSettings, recipe: InputRecipe, folder: Path
) -> bool:
    """Whether `trained` would leave the network as it is.

    Raises:
        InputError: The folder holds another network.
    """
    return is_done(folder, _training_made_of(objects, settings, recipe))


def _training_made_of(
    objects: ObjectSet, settings: TrainingSettings, recipe: InputRecipe
) -> dict[str, Any]:
    return {VERSION: __version__, **run_config(settings, recipe, objects.digest)}


def measured(
    weights: Path,
    objects: ObjectSet,
    yaw_deg: list[float],
    folder: Path,
    progress: Callable[[int, int], None] | None = None,
) -> YawSweep:
    """Name all objects at all yaws, or read what was found before.

    Raises:
        InputError: The folder holds what was found with other weights, objects or yaws, or a sweep
            that is broken.
        OutputError: It can not be written.
    """
    made_of = _sweep_made_of(weights, objects, yaw_deg)
    if not is_done(folder, made_of):
        sweep = sweep_yaw(load_predictor(weights), objects, yaw_deg, progress)
        sweep.save(folder / SWEEP)
        write_json(folder / "metrics.json", sweep.metrics())
        write_json(folder / MADE_OF, made_of)
    return _stored_sweep(folder, objects, yaw_deg)


def is_measured(weights: Path, objects: ObjectSet, yaw_deg: list[float], folder: Path) -> bool:
    """Whether `measured` would read what was found before.

    Raises:
        InputError: The folder holds what was found with other weights, objects or yaws.
    """
    return is_done(folder, _sweep_made_of(weights, objects, yaw_deg))


def _sweep_made_of(weights: Path, objects: ObjectSet, yaw_deg: list[float]) -> dict[str, Any]:
    return {
        VERSION: __version__,
        "weights": file_digest(weights),
        "data": objects.digest,
        "yaw_deg": list(yaw_deg),
    }


def _stored_sweep(folder: Path, objects: ObjectSet, yaw_deg: list[float]) -> YawSweep:
    """What a sweep is made of is told beside it: the file itself may be another stage's."""
    try:
        sweep = YawSweep.load(folder / SWEEP)
    except InputError as error:
        raise InputError(f"{error}; {_made_anew(folder)}") from error
    shape = (len(yaw_deg), len(objects), len(objects.classes))
    if not (
        np.array_equal(sweep.yaw_deg, yaw_deg)
        and np.array_equal(sweep.labels, objects.labels)
        and sweep.classes == objects.classes
        and sweep.probabilities.shape == shape
        and np.isfinite(sweep.probabilities).all()
    ):
        raise InputError(
            f"{folder / SWEEP}: is not of the {len(yaw_deg)} yaws and {len(objects)} objects that "
            f"{MADE_OF} tells of; {_made_anew(folder)}"
        )
    return sweep


def done_once(folder: Path, made_of: dict[str, Any], make: Callable[[], Any], form: Form) -> Any:
    """What `make` gives, as JSON types, or what it gave before.

    Args:
        folder: Of the stage.
        made_of: What determines the result.
        make: Makes it.
        form: What the result looks like.

    Raises:
        InputError: The folder holds a result that was made of something else, or that is broken.
        OutputError: It can not be written.
    """
    if not is_stored(folder, made_of):
        write_json(folder / RESULT, make())
        write_json(folder / MADE_OF, {VERSION: __version__, **made_of})
    try:
        found = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{folder / RESULT}: can not be read; {_made_anew(folder)}") from error
    if not fits(found, form):
        raise InputError(f"{folder / RESULT}: holds no result of this stage; {_made_anew(folder)}")
    return found


def is_stored(folder: Path, made_of: dict[str, Any]) -> bool:
    """Whether `done_once` would read what was made before.

    Raises:
        InputError: The folder holds a result that was made of something else.
    """
    return is_done(folder, {VERSION: __version__, **made_of})


def _made_anew(folder: Path) -> str:
    """How to go on where a stage's result is broken."""
    return f"remove the folder {folder}, and it is made anew"


def write_report(document: dict[str, Any], text: str, folder: Path, name: str) -> None:
    """What came out: `NAME.json` for programs and `NAME.md` for readers.

    Raises:
        OutputError: They can not be written.
    """
    write_json(folder / f"{name}.json", document)
    with atomic_open(folder / f"{name}.md") as stream:
        stream.write(text)


def file_digest(path: Path) -> str:
    """What tells a file's content from any other."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def is_done(folder: Path, made_of: dict[str, Any]) -> bool:
    """Whether a stage's result is there: it is written before what it was made of.

    Raises:
        InputError: What is there was made of something else.
    """
    try:
        found = json.loads((folder / MADE_OF).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return False
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{folder / MADE_OF}: can not be read; choose another --out") from error
    if not isinstance(found, dict):
        raise InputError(
            f"{folder / MADE_OF}: tells of no result, but holds a {type(found).__name__}; choose "
            "another --out"
        )
    if VERSION in made_of and VERSION not in found:
        raise _of_unknown_version(folder)
    if other := config_differences(found, json.loads(json.dumps(made_of))):
        raise InputError(f"{folder}: holds a result with other {other}; choose another --out")
    return True


def _require_own_state(folder: Path) -> None:
    """An unfinished run goes on in the version that began it: `train` itself does not ask."""
    if not (folder / STATE).exists():
        return
    version = state_version(folder / STATE)
    if version is None:
        raise _of_unknown_version(folder)
    if version != __version__:
        raise InputError(
            f"{folder}: holds a run that version {version} began, not {__version__}; choose "
            "another --out"
        )


def _of_unknown_version(folder: Path) -> InputError:
    return InputError(
        f"{folder}: does not tell which version of circumspect made it, and this is {__version__}; "
        "choose another --out"
    )
