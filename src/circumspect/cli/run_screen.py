"""What `demo` and `replay` show while they run and when they end."""

from __future__ import annotations

import json
import sys
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from circumspect.cli.progress import bars

if TYPE_CHECKING:
    from circumspect.pipeline import RecognitionResult, RecognitionStep, RunFolder

TELL_EVERY = 6
"""Frames between two lines where standard error is no terminal."""


def new_run_folder(command: str) -> Path:
    """A folder that does not exist yet: runs/COMMAND-DATE-TIME in the current folder."""
    name = f"{command}-{datetime.now():%Y%m%d-%H%M%S}"
    folder, count = Path("runs") / name, 1
    while folder.exists():
        count += 1
        folder = Path("runs") / f"{name}-{count}"
    return folder


class RunScreen:
    """Live progress on standard error; a `PipelineObserver` and a context manager."""

    def __init__(self, what: str, frames: int) -> None:
        self._progress = bars()
        self._live = self._progress.console.is_terminal
        self._task = self._progress.add_task(what, total=frames, note="")
        self._frames = frames

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.stop()

    def on_step(self, step: RecognitionStep) -> None:
        """Show frame, share of the object seen, running class and probability."""
        answer = step.outcome
        if step.prediction is not None:
            answer = f"{step.prediction.label} {step.prediction.probability:.2f}"
        note = f"seen {step.seen:4.0%}  {answer}"
        self._progress.update(self._task, advance=1, note=note)
        if not self._live and (step.index % TELL_EVERY == 0 or step.index == self._frames - 1):
            print(f"frame {step.index + 1:3}/{self._frames}  {note}", file=sys.stderr)  # noqa: T201

    def say(self, text: str) -> None:
        """Print a line on standard error above the progress."""
        self._progress.console.print(f"circumspect: {text}", highlight=False, markup=False)

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing: the command tells the end."""


def tell_result(result: RecognitionResult, folder: RunFolder, as_json: bool, head: Any) -> None:
    """Print how a run ended.

    Args:
        result: The run.
        folder: Where it was written.
        as_json: One JSON line instead of sentences.
        head: The first entries of the JSON line.
    """
    from circumspect.pipeline.run_folder import result_document

    if as_json:
        document = {**head, **result_document(result, folder.config), "run": str(folder.path)}
        print(json.dumps(document))  # noqa: T201
        return
    print(_sentence(result, folder.config.get("truth")))  # noqa: T201
    missing = f" (no picture: {folder.picture_missing})" if folder.picture_missing else ""
    shown = folder.path if folder.picture_missing else folder.path / "picture.png"
    print(f"All of it is in {folder.path}; start with {shown}{missing}")  # noqa: T201


def _sentence(result: RecognitionResult, truth: str | None) -> str:
    prediction, last = result.prediction, result.last
    if prediction is None or last is None:
        reasons = sorted({step.outcome for step in result.steps})
        return f"No answer after {len(result.steps)} frames: {', '.join(reasons) or 'no frames'}."
    answer = (
        f"{prediction.label} with probability {prediction.probability:.2f} after "
        f"{len(result.steps)} frames, seen from {last.seen:.0%} of the directions"
    )
    if truth is None:
        return f"It is named {answer}."
    verdict = "Right" if truth == prediction.label else "Wrong"
    return f"{verdict}: it is a {truth} and is named {answer}."
