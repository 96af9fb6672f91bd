"""Patches that replace functions by neutral versions, for ablations."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np


@dataclass(frozen=True)
class Patch:
    """A function and its neutral version.

    Attributes:
        owner: The module or class.
        name: Its attribute.
        neutral: Its replacement: a function, a property, or the value of a constant.
        pure: Whether both may be called on the same arguments and their results be compared.
    """

    owner: Any
    name: str
    neutral: Any
    pure: bool = False


@dataclass(frozen=True)
class Rule:
    """A part of the tracker that determines whether a pose is correct, or its uncertainty.

    Attributes:
        name: Name in tables.
        neutral: Effect of switching it off.
        patches: Patches that switch it off.
    """

    name: str
    neutral: str
    patches: tuple[Patch, ...]


def without(rules: Iterable[Rule]) -> ExitStack:
    """A context without some rules. Of two patches of the same function the later one counts."""
    stack = ExitStack()
    for rule in rules:
        for one in rule.patches:
            stack.enter_context(patch.object(one.owner, one.name, one.neutral))
    return stack


@contextmanager
def probed(rules: Sequence[Rule]) -> Iterator[set[str]]:
    """A context that collects the names of the rules that make a difference.

    A rule makes none if its functions are not called, or if they are pure and their neutral
    versions return the same at every call. Then a run without the rule is identical.
    """
    active: set[str] = set()
    by_function: dict[tuple[Any, str], list[tuple[Rule, Patch]]] = defaultdict(list)
    for rule in rules:
        for one in rule.patches:
            if callable(_function(one.owner, one.name)):
                by_function[one.owner, one.name].append((rule, one))
            else:
                active.add(rule.name)  # reads of a constant are not observable
    with ExitStack() as stack:
        for (owner, name), probes in by_function.items():
            probe: Any = _probe(_function(owner, name), probes, active)
            if isinstance(getattr(owner, name), property):
                probe = property(probe)
            stack.enter_context(patch.object(owner, name, probe))
        yield active


def _function(owner: Any, name: str) -> Any:
    """The function itself, or the getter of a property."""
    return _called(getattr(owner, name))


def _called(attribute: Any) -> Any:
    return attribute.fget if isinstance(attribute, property) else attribute


def _probe(
    original: Callable[..., Any], probes: list[tuple[Rule, Patch]], active: set[str]
) -> Callable[..., Any]:
    def called(*args: Any, **kwargs: Any) -> Any:
        found = original(*args, **kwargs)
        for rule, one in probes:
            if rule.name not in active and not (
                one.pure and _same(_called(one.neutral)(*args, **kwargs), found)
            ):
                active.add(rule.name)
        return found

    return called


def _same(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)
