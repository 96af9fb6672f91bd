"""Processing times of the stages."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Concatenate, ParamSpec, Protocol, TypeVar


class StageClock:
    """Sums up the time of named stages [ms]."""

    def __init__(self) -> None:
        self.milliseconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time a block; a stage entered twice counts both times."""
        start = time.perf_counter()
        try:
            yield
        finally:
            spent = 1e3 * (time.perf_counter() - start)
            self.milliseconds[name] = self.milliseconds.get(name, 0.0) + spent


class Timed(Protocol):
    """An object with a clock."""

    @property
    def clock(self) -> StageClock:
        """Times the stages."""
        ...


P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T", bound=Timed)


def timed(
    stage: str,
) -> Callable[[Callable[Concatenate[T, P], R]], Callable[Concatenate[T, P], R]]:
    """Decorate a method to add its time to a stage of its object's clock."""

    def decorated(method: Callable[Concatenate[T, P], R]) -> Callable[Concatenate[T, P], R]:
        @functools.wraps(method)
        def called(self: T, *args: P.args, **kwargs: P.kwargs) -> R:
            with self.clock.stage(stage):
                return method(self, *args, **kwargs)

        return called

    return decorated
