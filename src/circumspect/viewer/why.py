"""Explanation of the answer, computed in the background on demand."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from circumspect.classification import Classifier, OnnxClassifier
from circumspect.classification.evidence import CellEvidence, cell_evidence
from circumspect.classification.example_table import NearExample, nearest_examples
from circumspect.errors import CircumspectError, printable
from circumspect.grid import OccupancyGrid
from circumspect.viewer.publisher import Publisher

MOST_OFTEN = 0.25
"""Maximum rate of explanations [Hz]; each runs the classifier hundreds of times."""
NEAREST = 5


@dataclass(frozen=True, eq=False)
class Explanation:
    """Explanation of an answer.

    Attributes:
        evidence: Evidence of each cell for the answer.
        nearest: Most similar training objects; empty if the classifier has none.
    """

    evidence: CellEvidence
    nearest: tuple[NearExample, ...]

    def at(self, points_xyz: NDArray[np.floating], yaw: float = 0.0) -> NDArray[np.float32]:
        """(n,) evidence at points (n, 3) [m] of the object rotated by a yaw [rad]."""
        centre = np.asarray(self.evidence.grid.grid.centre_xyz)
        back = Rotation.from_euler("z", -yaw).apply(np.asarray(points_xyz, float) - centre)
        return self.evidence.at(np.ascontiguousarray(back + centre))


@dataclass(frozen=True, eq=False)
class _Question:
    """A grid and the identity of its run."""

    grid: OccupancyGrid
    run: object


class Why:
    """Explains the newest grid in its own thread.

    Attributes:
        wanted: Whether explanations are requested.
        found: The latest explanation of the current run.
        failure: Why there is none, in words.
    """

    def __init__(self, classifier: Classifier, on_found: Callable[[], None]) -> None:
        """Start the thread.

        Args:
            classifier: The classifier whose answers are explained.
            on_found: Called when an explanation is ready.
        """
        self.wanted = False
        self.found: Explanation | None = None
        self.failure = ""
        self._classifier, self._on_found = classifier, on_found
        self._asked: OccupancyGrid | None = None
        self._run: object = None
        self._turning = threading.Lock()
        self._work: Publisher[_Question] = Publisher(self._explain, most_often=MOST_OFTEN)

    def ask(self, grid: OccupancyGrid | None, run: object = None) -> None:
        """Schedule an explanation of a grid if requested; returns immediately.

        Args:
            grid: Grid of the object; None if there is none yet.
            run: Identity of the run; the explanation of another run is dropped.
        """
        with self._turning:
            if run is not self._run:
                self._run, self._asked = run, None
                self.found, self.failure = None, ""
        if self.wanted and grid is not None and grid is not self._asked:
            self._asked = grid
            self._work.slot.put(_Question(grid, run))

    def close(self) -> None:
        """End the thread."""
        self._work.close()

    def html(self) -> str:
        """The explanation as HTML for the panel."""
        if self.failure:
            return _box(escape(self.failure[:300]))
        if self.found is None:
            return _box("asking the classifier …" if self.wanted else "")
        label = escape(self.found.evidence.label)
        text = (
            f"<b style='color:#ca2c22'>red</b> cells speak for <b>{label}</b>, "
            "<b style='color:#2563be'>blue</b> ones against it"
        )
        if self.found.nearest:
            rows = "".join(
                f"<tr><td style='padding-right:1em'>{escape(printable(near.name))}</td>"
                f"<td style='padding-right:1em'>{escape(near.label)}</td>"
                f"<td style='text-align:right'>{near.distance:.3f}</td></tr>"
                for near in self.found.nearest
            )
            text += (
                "<div style='margin-top:.4em'>nearest training objects, and how far off:</div>"
                f"<table>{rows}</table>"
            )
        return _box(text)

    def _explain(self, question: _Question) -> None:
        found, failure = None, ""
        try:
            if not isinstance(self._classifier, OnnxClassifier):
                raise CircumspectError("only ONNX classifiers can be explained")
            evidence = cell_evidence(self._classifier, question.grid, metric=True)
            found = Explanation(evidence, self._nearest(self._classifier, question.grid))
        except CircumspectError as error:
            failure = str(error)
        with self._turning:
            if question.run is self._run:
                self.found, self.failure = found, failure
        self._on_found()

    def _nearest(self, classifier: OnnxClassifier, grid: OccupancyGrid) -> tuple[NearExample, ...]:
        try:
            return nearest_examples(classifier, grid, NEAREST, metric=True)
        except CircumspectError:
            return ()  # There is no table for these weights.


def _box(content: str) -> str:
    return f"<div style='padding:.2em 1em;font-size:.85em'>{content}</div>"
