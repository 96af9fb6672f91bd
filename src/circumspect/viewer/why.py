"""Why the answer is what it is: found out beside everything else, and only on demand."""

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
"""Explanations a second at most: each asks the classifier hundreds of times."""
NEAREST = 5


@dataclass(frozen=True, eq=False)
class Explanation:
    """What was found out.

    Attributes:
        evidence: What each cell says for the answer.
        nearest: The training objects most alike; empty where none are known for the classifier.
    """

    evidence: CellEvidence
    nearest: tuple[NearExample, ...]

    def at(self, points_xyz: NDArray[np.floating], yaw: float = 0.0) -> NDArray[np.float32]:
        """(n,) evidence at points (n, 3) [m] of the object turned by a yaw [rad]."""
        centre = np.asarray(self.evidence.grid.grid.centre_xyz)
        back = Rotation.from_euler("z", -yaw).apply(np.asarray(points_xyz, float) - centre)
        return self.evidence.at(np.ascontiguousarray(back + centre))


@dataclass(frozen=True, eq=False)
class _Question:
    """A grid, and what tells its run from another."""

    grid: OccupancyGrid
    run: object


class Why:
    """Explains the newest grid in a thread of its own.

    Attributes:
        wanted: Whether somebody wants to know.
        found: The latest explanation of the run that was asked about last.
        failure: Why there is none, in words.
    """

    def __init__(self, classifier: Classifier, tell: Callable[[], None]) -> None:
        """Start the thread.

        Args:
            classifier: Whose answers are explained.
            tell: Called when something was found out.
        """
        self.wanted = False
        self.found: Explanation | None = None
        self.failure = ""
        self._classifier, self._tell = classifier, tell
        self._asked: OccupancyGrid | None = None
        self._run: object = None
        self._turning = threading.Lock()
        self._work: Publisher[_Question] = Publisher(self._explain, most_often=MOST_OFTEN)

    def ask(self, grid: OccupancyGrid | None, run: object = None) -> None:
        """Explain a grid soon if that is wanted; returns at once.

        Args:
            grid: Of the object; None where there is none yet.
            run: Whose grid it is: what was found out in another run is forgotten.
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
        """What was found out, for the panel."""
        if self.failure:
            return _box(escape(self.failure[:300]))
        if self.found is None:
            return _box("asking the classifier …" if self.wanted else "")
        label = escape(self.found.evidence.label)
        told = (
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
            told += (
                "<div style='margin-top:.4em'>nearest training objects, and how far off:</div>"
                f"<table>{rows}</table>"
            )
        return _box(told)

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
        self._tell()

    def _nearest(self, classifier: OnnxClassifier, grid: OccupancyGrid) -> tuple[NearExample, ...]:
        try:
            return nearest_examples(classifier, grid, NEAREST, metric=True)
        except CircumspectError:
            return ()  # No table belongs to these weights.


def _box(content: str) -> str:
    return f"<div style='padding:.2em 1em;font-size:.85em'>{content}</div>"
