"""What `scan`, `demo` and `replay` show while they run and when they end."""

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
"""Exit code of a run that went well but names nothing."""
TELL_EVERY = 6
"""Frames between two lines where standard error is no terminal."""


def new_run_folder(command: str) -> Path:
    """Make a folder for a run alone: runs/COMMAND-DATE-TIME in the current folder.

    Args:
        command: What it is named after; runs that begin in the same second are numbered.

    Raises:
        OutputError: It can not be made.
    """
    return make_new_folder(Path("runs") / f"{command}-{datetime.now():%Y%m%d-%H%M%S}")


class RunScreen:
    """Live progress on standard error; a `PipelineObserver` and a context manager."""

    def __init__(
        self, what: str, total: float, done: Callable[[RecognitionStep], float] | None = None
    ) -> None:
        """Show nothing yet.

        Args:
            what: What is being done, in few words.
            total: When it is all done.
            done: How much is done after a step; None counts frames.
        """
        self._progress = bars()
        self._live = self._progress.console.is_terminal
        self._task = self._progress.add_task(what, total=total, note="")
        self._total = total
        self._done = done
        self.label: str | None = None
        """What the object was called after the latest frame; None before that."""

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
        """Show progress, coverage, the answer so far, and what is wrong with the pose."""
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
        if not self._live and (step.index % TELL_EVERY == 0 or last):
            if step.pose is not None and not is_reliable:
                note += f"  pose not reliable: {step.pose.reason}"
            where = f"/{self._total}" if self._done is None else f"  {done:3.0f}/{self._total}"
            print(f"frame {count:3}{where}  {note}", file=sys.stderr)  # noqa: T201

    def say(self, text: str) -> None:
        """Print a line on standard error above the progress."""
        line = f"circumspect: {printable(text)}"
        # A terminal wraps by words; a file gets one line for one thing that is said.
        self._progress.console.print(line, highlight=False, markup=False, soft_wrap=not self._live)

    def on_end(self, result: RecognitionResult) -> None:
        """Nothing: the command tells the end."""


def tell_result(
    result: RecognitionResult,
    folder: RunFolder,
    as_json: bool,
    head: Any,
    on_the_way: str | None = None,
) -> None:
    """Print how a run ended.

    Args:
        result: The run.
        folder: Where it was written.
        as_json: One JSON line instead of sentences.
        head: The first entries of the JSON line.
        on_the_way: What the object was called after the last frame.
    """
    if as_json:
        document = {**head, **folder.document(result), "run": str(folder.path)}
        print(json.dumps(document))  # noqa: T201
        return
    for sentence in answer_sentences(result, folder.config.get("truth"), on_the_way):
        print(wrapped(sentence))  # noqa: T201
    tell_where(folder)


def answer_sentences(
    result: RecognitionResult, truth: str | None, on_the_way: str | None = None
) -> list[str]:
    """The answer, and what there is to know about it.

    Args:
        result: The run.
        truth: What the object is, where that is known.
        on_the_way: What it was called after the last frame.
    """
    told = verdict(result, truth), renamed(result, on_the_way), unused(result)
    return [sentence for sentence in told if sentence]


def tell_where(folder: RunFolder) -> None:
    """Print where the run was written, and with what to start."""
    hint = "; begin with picture.png there"
    if folder.picture_missing:
        hint = f" (no picture: {folder.picture_missing})"
    print(f"All of it is in {folder.path}{hint}")  # noqa: T201


def verdict(result: RecognitionResult, truth: str | None) -> str:
    """The answer in sentences, compared with the ground truth where that is known."""
    prediction, last = result.prediction, result.last
    if prediction is None or last is None:
        reasons = sorted({step.outcome for step in result.steps})
        return f"No answer after {_frames(result)}: {', '.join(reasons) or 'no frames'}."
    told = f"Result: {prediction.text}, {_frames(result)}, {percent(last.coverage)} coverage."
    told += f" Not confident: {prediction.reason}." if prediction.reason else " Confident."
    if truth is not None:
        judged = truth_text(prediction.label, prediction.in_distribution, truth)
        told += f" {judged[0].upper()}{judged[1:]}."
    return told


def renamed(result: RecognitionResult, on_the_way: str | None) -> str:
    """Why the answer is not that of the last frame told, in a sentence; empty where it is."""
    prediction = result.prediction
    if prediction is None or on_the_way in (None, prediction.label):
        return ""
    return (
        f"After the last frame the answer was {on_the_way}; the result is that of the whole model, "
        "after loop closure."
    )


def unused(result: RecognitionResult) -> str:
    """Which frames are not part of the answer, in a sentence; empty where all are."""
    from circumspect.recognition import FrameOutcome

    if result.prediction is None:
        return ""
    if (lost := result.lost_from) is not None:
        return f"The camera was lost from frame {lost} on; the answer is of what it saw until then."
    used = (FrameOutcome.CLASSIFIED, FrameOutcome.TOO_LITTLE)
    reasons = Counter(step.outcome for step in result.steps if step.outcome not in used)
    if not reasons:
        return ""
    told = ", ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
    return f"Frames that are not part of it: {told}."


def _frames(result: RecognitionResult) -> str:
    count = len(result.steps)
    return "1 frame" if count == 1 else f"{count} frames"


def wrapped(sentence: str) -> str:
    """As wide as the terminal; a number and its unit stay together."""
    joined = re.sub(r"(?<=\d) (?=m?m\b|%)", "\u00a0", sentence)
    return fill(joined, shutil.get_terminal_size().columns).replace("\u00a0", " ")
