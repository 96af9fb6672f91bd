"""When more views are no longer needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from circumspect.errors import InputError
from circumspect.planning.answer import Answer


@dataclass(frozen=True)
class StoppingCriterion:
    """The answer is final once it was confident, with the same label, in several frames.

    What makes an answer confident is the classifier's rule; this criterion has no bounds of its
    own.

    Attributes:
        frames: How many consecutive answers are needed.

    Raises:
        InputError: Fewer than one frame.
    """

    frames: int = 3

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f"a stopping criterion needs at least 1 frame, not {self.frames}")

    def reached(self, answers: Sequence[Answer]) -> str | None:
        """Why the answer is final; None while it is not.

        Args:
            answers: Those so far, one a frame that showed the object.
        """
        last = answers[-self.frames :]
        if len(last) < self.frames or not all(answer.confident for answer in last):
            return None
        label = last[-1].label
        if any(answer.label != label for answer in last):
            return None
        return f"the answer is confident: {label} in {self.frames} consecutive frames"
