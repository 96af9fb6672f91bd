"""The answer to what the object is, provisional or final."""

from __future__ import annotations

from circumspect.classification import Classifier, Prediction
from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.recognition.object_grids import ObjectGrids
from circumspect.reconstruction import ObjectModel

MAX_GRIDS_A_FRAME = 4
"""Grids that are classified with each frame; the final answer is that of all grids."""


class ObjectAnswer:
    """Grids and classifies the object model.

    After a frame, a few grids of the preview model give a provisional answer. Once no more frames
    come, all grids of the full model give the final one.

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

    def grid(self, model: ObjectModel, *, final: bool = False) -> FrameOutcome | None:
        """Grid the model; an object that is too wide loses its answer.

        Args:
            model: The full model.
            final: Whether all grids of the full model are filled.

        Returns:
            Why the object cannot be classified; None if it can.
        """
        source, max_grids = (model, None) if final else (model.preview, MAX_GRIDS_A_FRAME)
        outcome = self.grids.update(source, max_grids)
        if outcome is FrameOutcome.TOO_WIDE:
            self.prediction = None
            self.is_provisional = source is not model
        return outcome

    def classify(self, model: ObjectModel, *, final: bool = False) -> None:
        """Classify the grids.

        Args:
            model: The full model.
            final: Whether the grids are those of the full model.
        """
        grids = self.grids.grids
        self.prediction = self._classifier.classify_grid(
            *grids, metric=True, coverage=self.grids.coverage
        )
        source = model if final else model.preview
        is_complete = len(grids) >= self._classifier.recipe.azimuth_views
        self.is_provisional = source is not model or not is_complete

    def on_replaced(self, model: ObjectModel) -> None:
        """Use a model that replaces the former one; it is classified with the next frame."""
        self.is_provisional = True  # even if the next frame is not used
        if self.grids.points_xyz is not None:
            self.grids.points_xyz = model.preview.points_xyz
