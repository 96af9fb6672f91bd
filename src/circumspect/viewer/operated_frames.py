"""Recorded frames with an onlooker, who may hold them back, and lose or cover some."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from circumspect.robot import Operator
from circumspect.sensing import RgbdFrame


class OperatedFrames:
    """Goes through frames as the operator wants; can be watched, see `Watchable`.

    Attributes:
        frame: The one that is worked on.
        target: None: a recording drives nowhere.
        ended: None while frames come, then why none come any more.
    """

    def __init__(self, frames: Iterable[RgbdFrame], operator: Operator, seed: int = 0) -> None:
        """Take no frame yet.

        Args:
            frames: In the order of their stamps.
            operator: Told by somebody else.
            seed: Says which frames are lost.
        """
        self.frame: RgbdFrame | None = None
        self.target = None
        self.ended: str | None = None
        self._frames, self._operator = frames, operator
        self._rng = np.random.default_rng(seed)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """The frames, each once it may be taken.

        Raises:
            RunStopped: The operator wants the run to end.
        """
        for frame in self._frames:
            self._operator.admit()
            if self._rng.random() < self._operator.dropped:
                continue
            self.frame = frame.covered() if self._operator.covered else frame
            yield self.frame
        self.ended = "the end of the recording"
