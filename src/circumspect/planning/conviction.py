"""When more views no longer change the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from circumspect.planning.answer import ENOUGH_SEEN, Answer


@dataclass(frozen=True)
class Conviction:
    """The answer is taken as final once it is sure, and has been so while more was seen.

    Nothing is sure of an object that is like none of the classes.

    Attributes:
        probability: The leading class has at least this …
        seen: … once this share of the directions was seen, 0 … 1 …
        over: … and while this share was added last …
        change: … its probability changed by no more than this, it led all the time, and the object
            was known.
    """

    probability: float = 0.8
    seen: float = ENOUGH_SEEN
    over: float = 0.15
    change: float = 0.08

    def reached(self, answers: Sequence[Answer]) -> str | None:
        """Why the answer is final; None while it is not.

        Args:
            answers: Those so far; where the object's middle is corrected, the share seen of it
                may fall.
        """
        if not answers or answers[-1].seen < self.seen:
            return None
        last = answers[-1]
        label = max(last.probabilities, key=lambda name: last.probabilities[name])
        now = last.probabilities[label]
        if now < self.probability:
            return None
        for answer in reversed(answers):
            then = answer.probabilities[label]
            wavers = abs(then - now) > self.change or max(answer.probabilities.values()) > then
            if wavers or not answer.known:
                return None
            if answer.seen <= last.seen - self.over:
                return f"sure of {label}: {now:.2f} while {self.over:.0%} more was seen"
        return None
