"""`circumspect evaluate` on labelled real objects."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from circumspect import __version__
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.evaluation.predictor import Predictor


def are_crops(paths: Sequence[Path]) -> bool:
    """Whether all of some paths are files of labelled real objects.

    Raises:
        InputError: Some are, others are not.
    """
    from circumspect.datasets.labelled_crops import is_labelled_crops

    found = [is_labelled_crops(path) for path in paths]
    if any(found) and not all(found):
        raise InputError(
            f"--data {paths[found.index(False)]}: no file of labelled real objects, as "
            f"{paths[found.index(True)].name} is; evaluate them one after the other"
        )
    return any(found)


def evaluate_crops(
    predictor: Predictor,
    identity: Mapping[str, str],
    paths: Sequence[Path],
    out: Path,
    *,
    scale: Literal["metric", "unknown"],
    as_json: bool,
) -> int:
    """Evaluate, write the results and print the report.

    Args:
        predictor: Classifies the objects.
        identity: What the report calls it, "model", and the hash of its file, "sha256".
        paths: Files of labelled crops.
        out: Folder of the results.
        scale: Whether the classifier is told that coordinates are metres.
        as_json: Print the measures as JSON in place of the report.

    Returns:
        Exit code.

    Raises:
        InputError: A file is broken, no label can be judged, or an object can not be classified.
        OutputError: The results can not be written.
    """
    from circumspect.cli.progress import progress_bar
    from circumspect.datasets.crop_sources import read_crop_sources, require_usable_labels
    from circumspect.evaluation.crop_answers import answer_crops
    from circumspect.evaluation.crop_evaluation import draw_crop_results, write_crop_results
    from circumspect.evaluation.crop_metrics import crop_metrics
    from circumspect.storage import write_json

    sources = read_crop_sources(paths)
    require_usable_labels(sources.values(), predictor.classes)
    head = {
        "circumspect": __version__,
        **identity,
        "scale": scale,
        "command": _command(identity["model"], paths, scale),
        "data": {name: crops.digest for name, crops in sources.items()},
    }
    # Before the work, so that a folder that can not be written is found at once.
    write_json(out / "evaluation.json", {**head, "data": [str(path) for path in paths]})
    with progress_bar("objects") as progress:
        answers = answer_crops(predictor, sources, scale, progress)
    metrics = {**head, **crop_metrics(answers, predictor.classes)}
    report = write_crop_results(out, metrics, answers)
    print(json.dumps(metrics) if as_json else report, flush=True)  # noqa: T201
    try:
        draw_crop_results(out, metrics, answers, sources)
    except MissingExtraError as error:
        say(f"no pictures: {error}")
    if not as_json:
        print(f"Results and pictures: {printable(str(out))}")  # noqa: T201
    return 0


def _command(model: str, paths: Sequence[Path], scale: str) -> str:
    """The command as a reader types it, without folders of this machine."""
    words = ["circumspect", "evaluate", "--data", *(path.name for path in paths)]
    words[2:2] = ["--model", model]
    if scale != "metric":
        words += ["--scale", scale]
    return printable(shlex.join(words)).replace("`", "'")
