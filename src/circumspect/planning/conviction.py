"""When more views no longer change the answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Conviction:
    """The answer is taken as final once it is sure, and has been so while more was seen.

    Attributes:
        probability: The leading class has at least this …
        seen: … once this share of the directions was seen, 0 … 1 …
        over: … and while this share was added last …
        change: … its probability changed by no more than this, and it led all the time.
    """

    probability: float = 0.8
    seen: float = 0.5
    over: float = 0.15
    change: float = 0.08

    def reached(
        self, probabilities: Sequence[Mapping[str, float]], shares_seen: Sequence[float]
    ) -> str | None:
        """Why the answer is final; None while it is not.

        Args:
            probabilities: The answers so far, class to probability.
            shares_seen: For each the share of directions seen until then, not falling.
        """
        if not probabilities or shares_seen[-1] < self.seen:
            return None
        label = max(probabilities[-1], key=lambda name: probabilities[-1][name])
        now = probabilities[-1][label]
        if now < self.probability:
            return None
        for answer, share in zip(reversed(probabilities), reversed(shares_seen), strict=True):
            if abs(answer[label] - now) > self.change or max(answer.values()) > answer[label]:
                return None
            if share <= shares_seen[-1] - self.over:
                return f"sure of {label}: {now:.2f} while {self.over:.0%} more was seen"
        return None
