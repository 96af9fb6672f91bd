"""Progress and results of `scan`, `demo` and `replay` in the terminal."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections import Counter
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from textwrap import fill
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from circumspect.classification.answer_text import percent, truth_text
from circumspect.cli.progress import bars
from circumspect.errors import printable
from circumspect.storage import make_new_folder

if TYPE_CHECKING:
    from circumspect.recognition import RecognitionResult, RecognitionStep
    from circumspect.runs import RunFolder

NO_ANSWER = 1
"""Exit code of a run without errors and without an answer."""
PRINT_EVERY_FRAMES = 6
"""Frames between two lines if standard error is no terminal."""


def new_run_folder(command: str) -> Path:
    """Make a new folder for a run: runs/COMMAND-DATE-TIME in the current folder.

    Args:
        command: First part of its name; runs that begin in the same second are numbered.

    Raises:
        OutputError: The folder can not be made.
    """
    return make_new_folder(Path("runs") / f"{command}-{datetime.now():%Y%m%d-%H%M%S}")


class RunScreen:
    """Shows progress on standard error; a `PipelineObserver` and a context manager."""

    def __init__(
        self, what: str, total: float, done: Callable[[RecognitionStep], float] | None = None
    ) -> None:
        """Prepare the progress bar.

        Args:
            what: Short description of the work.
            total: Total amount of work.
            done: Returns the amount of work done after a step; None counts frames.
        """
        self._progress = bars()
        self._live = self._progress.console.is_terminal
        self._task = self._progress.add_task(what, total=total, note="")
        self._total = total
        self._done = done
        self.label: str | None = None
        """Label after the latest frame; None before the first answer."""

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
        """Show progress, coverage, the current answer, and whether the pose is reliable."""
        answer = step.outcome
        if step.prediction is not None:
            self.label = step.prediction.label
            answer = step.prediction.text + ("" if step.confident else ", not confident")
        note = f"coverage {percent(step.coverage):>5}  {answer}"
        is_reliable = step.pose is None or step.pose.reliable
        count = step.index + 1
        done = count if self._done is None else min(self._done(step), self._total)
        live = note if is_reliable else f"{note}  pose not reliable"
        self._progress.update(self._task, completed=done, note=live)
        last = self._done is None and count == self._total
        if not self._live and (step.index % PRINT_EVERY_FRAMES == 0 or last):
            if step.pose is not None and not is_reliable:
                note += f"  pose not reliable: {step.pose.reason}"
            where = f"/{self._total}" if self._done is None else f"  {done:3.0f}/{self._total}"
            print(f"frame {count:3}{where}  {note}", file=sys.stderr)  # noqa: T201

    def say(self, text: str) -> None:
        """Print a line on standard error above the progress."""
        line = f"circumspect: {printable(text)}"
        # A terminal wraps by words; a file gets one line per message.
        self._progress.console.print(line, highlight=False, markup=False, soft_wrap=not self._live)

    def on_end(self, result: RecognitionResult) -> None:
        """Do nothing; the command prints the result."""


def print_result(
    result: RecognitionResult,
    folder: RunFolder,
    as_json: bool,
    head: Any,
    on_the_way: str | None = None,
) -> None:
    """Print the result of a run.

    Args:
        result: Result of the run.
        folder: Folder of the run.
        as_json: Print one JSON line instead of sentences.
        head: First entries of the JSON line.
        on_the_way: Label after the last frame.
    """
    if as_json:
        document = {**head, **folder.document(result), "run": str(folder.path)}
        print(json.dumps(document))  # noqa: T201
        return
    for sentence in answer_sentences(result, folder.config.get("truth"), on_the_way):
        print(wrapped(sentence))  # noqa: T201
    print_folder(folder)


def answer_sentences(
    result: RecognitionResult, truth: str | None, on_the_way: str | None = None
) -> list[str]:
    """The answer of a run and notes about it, in sentences.

    Args:
        result: Result of the run.
        truth: True label, if known.
        on_the_way: Label after the last frame.
    """
    sentences = verdict(result, truth), renamed(result, on_the_way), unused(result)
    return [sentence for sentence in sentences if sentence]


def print_folder(folder: RunFolder) -> None:
    """Print the folder of the run and the file to open first."""
    hint = "; begin with picture.png there"
    if folder.picture_missing:
        hint = f" (no picture: {folder.picture_missing})"
    print(f"All of it is in {folder.path}{hint}")  # noqa: T201


def verdict(result: RecognitionResult, truth: str | None) -> str:
    """The answer in sentences, compared with the true label if known."""
    prediction, last = result.prediction, result.last
    if prediction is None or last is None:
        reasons = sorted({step.outcome for step in result.steps})
        return f"No answer after {_frames(result)}: {', '.join(reasons) or 'no frames'}."
    text = f"Result: {prediction.text}, {_frames(result)}, {percent(last.coverage)} coverage."
    text += f" Not confident: {prediction.reason}." if prediction.reason else " Confident."
    if truth is not None:
        judged = truth_text(prediction.label, prediction.in_distribution, truth)
        text += f" {judged[0].upper()}{judged[1:]}."
    return text


def renamed(result: RecognitionResult, on_the_way: str | None) -> str:
    """A sentence about an answer that differs from the last printed one; empty otherwise."""
    prediction = result.prediction
    if prediction is None or on_the_way in (None, prediction.label):
        return ""
    return (
        f"After the last frame the answer was {on_the_way}; the result is that of the whole model, "
        "after loop closure."
    )


def unused(result: RecognitionResult) -> str:
    """A sentence about frames that were not used for the answer; empty if all were used."""
    from circumspect.recognition import FrameOutcome

    if result.prediction is None:
        return ""
    if (lost := result.lost_from) is not None:
        return f"The camera was lost from frame {lost} on; the answer is of what it saw until then."
    used = (FrameOutcome.CLASSIFIED, FrameOutcome.TOO_LITTLE)
    reasons = Counter(step.outcome for step in result.steps if step.outcome not in used)
    if not reasons:
        return ""
    counts = ", ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
    return f"Frames that are not part of it: {counts}."


def _frames(result: RecognitionResult) -> str:
    count = len(result.steps)
    return "1 frame" if count == 1 else f"{count} frames"


def wrapped(sentence: str) -> str:
    """Wrap a sentence to the terminal; a number and its unit stay together."""
    joined = re.sub(r"(?<=\d) (?=m?m\b|%)", "\u00a0", sentence)
    return fill(joined, shutil.get_terminal_size().columns).replace("\u00a0", " ")
