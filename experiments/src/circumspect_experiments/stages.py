"""Stages of an experiment: each runs once, and results of different experiments never mix."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from circumspect import __version__
from circumspect.classification import InputSpec
from circumspect.datasets import GridCache, ObjectSet
from circumspect.errors import InputError
from circumspect.evaluation.predictor import load_predictor
from circumspect.evaluation.yaw_sweep import YawSweep, sweep_yaw
from circumspect.storage import atomic_open, write_json
from circumspect.training import TrainingSettings
from circumspect.training.resume import state_version
from circumspect.training.run_config import BEST, MADE_OF, STATE, config_differences, run_config
from circumspect.training.train import TrainingObserver, train

SWEEP = "sweep.npz"
RESULT = "result.json"
VERSION = "circumspect"
"""Key of the package version that made a result."""
Form = type | Sequence[Any] | Mapping[str, Any]
"""Expected structure of a result: a type, or forms in a list or a dictionary."""


class Watched(Protocol):
    """Displays the progress of an experiment."""

    def training(self, name: str, epochs: int) -> AbstractContextManager[TrainingObserver]:
        """Context of the training of a network."""
        ...

    def measuring(
        self, name: str, counted: str = "objects"
    ) -> AbstractContextManager[Callable[[int, int], None]]:
        """Context of a measurement; yields a function to call with (done, all)."""
        ...


def trained(
    objects: ObjectSet,
    settings: TrainingSettings,
    input_spec: InputSpec,
    folder: Path,
    observer: TrainingObserver,
    cache: GridCache | None = None,
) -> Path:
    """Train a network, resume its training, or keep it if it is finished.

    Returns:
        The checkpoint of the epoch that is kept.

    Raises:
        InputError: The folder contains another run, a run of another version of the package, or a
            run without its network.
        OutputError: It can not be written.
        WeightsError: The state of an unfinished run is broken.
    """
    made_of = _training_made_of(objects, settings, input_spec)
    if not is_done(folder, made_of):
        _require_own_state(folder)
        train(objects, settings, folder, observer, cache, input_spec)
        write_json(folder / MADE_OF, made_of)
    elif not (folder / BEST).is_file():
        raise InputError(f"{folder / BEST}: is missing; {_removal_hint(folder)}")
    # The state has hundreds of megabytes, and only an unfinished run needs it.
    (folder / STATE).unlink(missing_ok=True)
    return folder / BEST


def is_trained(
    objects: ObjectSet, settings: TrainingSettings, input_spec: InputSpec, folder: Path
) -> bool:
    """Whether `trained` would keep the network as it is.

    Raises:
        InputError: The folder holds another network.
    """
    return is_done(folder, _training_made_of(objects, settings, input_spec))


def _training_made_of(
    objects: ObjectSet, settings: TrainingSettings, input_spec: InputSpec
) -> dict[str, Any]:
    return {VERSION: __version__, **run_config(settings, input_spec, objects.digest)}


def measured(
    weights: Path,
    objects: ObjectSet,
    yaw_deg: list[float],
    folder: Path,
    progress: Callable[[int, int], None] | None = None,
) -> YawSweep:
    """Classify all objects at all yaws, or read the stored result.

    Raises:
        InputError: The folder holds a result of other weights, objects or yaws, or a broken sweep.
        OutputError: It can not be written.
    """
    made_of = _sweep_made_of(weights, objects, yaw_deg)
    if not is_done(folder, made_of):
        sweep = sweep_yaw(load_predictor(weights), objects, yaw_deg, progress)
        sweep.save(folder / SWEEP)
        write_json(folder / "metrics.json", sweep.to_dict())
        write_json(folder / MADE_OF, made_of)
    return _stored_sweep(folder, objects, yaw_deg)


def is_measured(weights: Path, objects: ObjectSet, yaw_deg: list[float], folder: Path) -> bool:
    """Whether `measured` would read a stored result.

    Raises:
        InputError: The folder holds a result of other weights, objects or yaws.
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
    """Read a sweep; its inputs are stored beside it."""
    try:
        sweep = YawSweep.load(folder / SWEEP)
    except InputError as error:
        raise InputError(f"{error}; {_removal_hint(folder)}") from error
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
            f"{MADE_OF} describes; {_removal_hint(folder)}"
        )
    return sweep


def done_once(folder: Path, made_of: dict[str, Any], make: Callable[[], Any], form: Form) -> Any:
    """The result of `make` as JSON types, or the stored one.

    Args:
        folder: Folder of the stage.
        made_of: All values that determine the result.
        make: Computes it.
        form: Structure of the result.

    Raises:
        InputError: The folder holds a result of something else, or a broken one.
        OutputError: It can not be written.
    """
    if not is_stored(folder, made_of):
        write_json(folder / RESULT, make())
        write_json(folder / MADE_OF, {VERSION: __version__, **made_of})
    try:
        found = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{folder / RESULT}: can not be read; {_removal_hint(folder)}") from error
    if not fits(found, form):
        raise InputError(
            f"{folder / RESULT}: holds no result of this stage; {_removal_hint(folder)}"
        )
    return found


def is_stored(folder: Path, made_of: dict[str, Any]) -> bool:
    """Whether `done_once` would read a stored result.

    Raises:
        InputError: The folder holds a result of something else.
    """
    return is_done(folder, {VERSION: __version__, **made_of})


def _removal_hint(folder: Path) -> str:
    """The remedy for a broken result of a stage, in words."""
    return f"remove the folder {folder}, and it is made again"


def write_report(document: dict[str, Any], text: str, folder: Path, name: str) -> None:
    """Write results: `NAME.json` for programs and `NAME.md` for readers.

    Raises:
        OutputError: They can not be written.
    """
    write_json(folder / f"{name}.json", document)
    with atomic_open(folder / f"{name}.md") as stream:
        stream.write(text)


def file_digest(path: Path) -> str:
    """SHA-256 of a file's content."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def is_done(folder: Path, made_of: dict[str, Any]) -> bool:
    """Whether a stage's result exists: it is written before `made_of`.

    Raises:
        InputError: The existing result was made of something else.
    """
    try:
        found = json.loads((folder / MADE_OF).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return False
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{folder / MADE_OF}: can not be read; choose another --out") from error
    if not isinstance(found, dict):
        raise InputError(
            f"{folder / MADE_OF}: describes no result, but holds a {type(found).__name__}; choose "
            "another --out"
        )
    if VERSION in made_of and VERSION not in found:
        raise _of_unknown_version(folder)
    if other := config_differences(found, json.loads(json.dumps(made_of))):
        raise InputError(f"{folder}: holds a result with other {other}; choose another --out")
    return True


def _require_own_state(folder: Path) -> None:
    """Check that an unfinished run is resumed in the version that began it.

    `train` does not check this.
    """
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
        f"{folder}: does not state which version of circumspect made it; this is {__version__}; "
        "choose another --out"
    )


def fits(found: Any, form: Form) -> bool:
    """Whether JSON types have a form: the same keys, lengths and types; numbers finite."""
    if isinstance(form, type):
        return type(found) is form and (form is not float or math.isfinite(found))
    if isinstance(form, Mapping):
        same = isinstance(found, dict) and found.keys() == form.keys()
        return same and all(fits(found[key], inner) for key, inner in form.items())
    same = isinstance(found, list) and len(found) == len(form)
    return same and all(map(fits, found, form))
