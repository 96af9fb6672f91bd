"""`circumspect evaluate` on labelled real objects."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from circumspect import __version__
from circumspect.cli.say import say
from circumspect.errors import InputError, MissingExtraError, printable

if TYPE_CHECKING:
    from circumspect.evaluation.predictor import Predictor


def are_crops(paths: Sequence[Path]) -> bool:
    """Whether paths are files of labelled real objects.

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
    claimed: Callable[[], None],
) -> int:
    """Evaluate, write the results and print the report.

    Args:
        predictor: Classifies the objects.
        identity: "model", its name in the report, and "sha256" of its file.
        paths: Files of labelled crops.
        out: Folder of the results.
        scale: Whether the classifier treats the coordinates as metres.
        as_json: Print the measures as JSON instead of the report.
        claimed: Called after the files are read and the folder is known to be writable.

    Returns:
        Exit code.

    Raises:
        InputError: A file is broken, no label can be judged, or an object can not be classified.
        OutputError: The results can not be written.
    """
    from circumspect.cli.progress import progress_bar
    from circumspect.datasets.labelled_crops import read_crop_sources, require_usable_labels
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
    # Written first, so that an output folder that can not be written is reported at once.
    write_json(out / "evaluation.json", {**head, "data": [str(path) for path in paths]})
    claimed()
    with progress_bar("objects") as progress:
        answers = answer_crops(predictor, sources, scale, progress)
    metrics = {**head, **crop_metrics(answers, predictor.classes)}
    _print(metrics, write_crop_results(out, metrics, answers), as_json)
    try:
        draw_crop_results(out, metrics, answers, sources)
    except MissingExtraError as error:
        say(f"no pictures: {error}")
    if not as_json:
        print(f"Results and pictures: {printable(str(out))}")  # noqa: T201
    return 0


def _print(metrics: Mapping[str, Any], report: str, as_json: bool) -> None:
    from circumspect.cli.report_screen import print_report

    if as_json:
        print(json.dumps(metrics), flush=True)  # noqa: T201
    else:
        print_report(report)


def _command(model: str, paths: Sequence[Path], scale: str) -> str:
    """The command for the report, without local folders."""
    words = ["circumspect", "evaluate", "--data", *(path.name for path in paths)]
    words[2:2] = ["--model", model]
    if scale != "metric":
        words += ["--scale", scale]
    return printable(shlex.join(words)).replace("`", "'")
