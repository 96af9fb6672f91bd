"""The answer of the classifier about the object, provisional or final."""

from __future__ import annotations

from circumspect.classification import Classifier, Prediction
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.recognition.object_grids import ObjectGrids
from circumspect.reconstruction import ObjectModel

MAX_GRIDS_A_FRAME = 4
"""Maximum number of grids classified with each frame; the final answer uses all grids."""
STABLE_ANSWERS = 3
"""After so many equal answers only the first grid is classified, until its answer differs."""


class ObjectAnswer:
    """Grids and classifies the object model.

    After a frame, a few grids of the preview model give a provisional answer. After the last
    frame, all grids of the full model give the final one.

    Attributes:
        grids: The grids of the object.
        prediction: The latest answer; None before the first.
        is_provisional: Whether the final answer can differ.
    """

    def __init__(self, classifier: Classifier) -> None:
        """Start without an answer.

        Args:
            classifier: Classifies the grids. Its input specification defines them.
        """
        self.grids = ObjectGrids(classifier)
        self.prediction: Prediction | None = None
        self.is_provisional = False
        self._classifier = classifier
        self._equal_answers = 0

    def grid(self, model: ObjectModel) -> FrameOutcome | None:
        """Grid the model after a frame; drop the answer if the object is too wide.

        Returns:
            Why the object cannot be classified; None if it can.
        """
        is_stable = self._equal_answers >= STABLE_ANSWERS
        outcome = self.grids.update(model, 1 if is_stable else MAX_GRIDS_A_FRAME)
        self._drop_if_too_wide(outcome)
        return outcome

    def classify(self, model: ObjectModel) -> None:
        """Classify the grids; a single grid can confirm an answer but not change it."""
        prediction = self._prediction()
        is_equal = _same(prediction, self.prediction)
        if not is_equal and self._equal_answers >= STABLE_ANSWERS:
            self.grids.update(model, MAX_GRIDS_A_FRAME)
            prediction = self._prediction()
        self._equal_answers = self._equal_answers + 1 if is_equal else 1
        self.prediction, self.is_provisional = prediction, True

    def finalise(self, model: ObjectModel) -> None:
        """Classify all grids of the full model."""
        outcome = self.grids.finalise(model)
        self._drop_if_too_wide(outcome)
        if outcome is None:
            self.prediction = self._prediction()
        self.is_provisional = False

    def on_replaced(self, model: ObjectModel) -> None:
        """Use a model that replaces the previous one; it is classified with the next frame."""
        self.is_provisional = True  # even if the next frame is not used
        if self.grids.points_xyz is not None:
            self.grids.points_xyz = model.preview.points_xyz

    def _drop_if_too_wide(self, outcome: FrameOutcome | None) -> None:
        if outcome is FrameOutcome.TOO_WIDE:
            self.prediction, self._equal_answers, self.is_provisional = None, 0, True

    def _prediction(self) -> Prediction:
        return self._classifier.classify_grid(
            *self.grids.grids, metric=True, coverage=self.grids.coverage
        )


def _same(one: Prediction, other: Prediction | None) -> bool:
    """Whether two answers have the same class and confidence."""
    return other is not None and (one.label, one.confident) == (other.label, other.confident)
