"""Names and numbers that nobody can change: what a prediction is made of."""

from __future__ import annotations

from typing import Any, NoReturn


def _refused(*_: Any, **__: Any) -> NoReturn:
    raise TypeError("the numbers of a prediction are read-only; write to dict(…) of them")


class ReadOnlyTable(dict[str, float]):
    """A dict that refuses to be written to and can be hashed.

    A `MappingProxyType` would do, but neither pickle nor `copy.deepcopy`, `json.dumps` or
    `dataclasses.asdict` take one.
    """

    __setitem__: Any = _refused
    __delitem__: Any = _refused
    __ior__: Any = _refused
    clear: Any = _refused
    pop: Any = _refused
    popitem: Any = _refused
    setdefault: Any = _refused
    update: Any = _refused

    def __hash__(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[type[ReadOnlyTable], tuple[dict[str, float]]]:
        # A dict is unpickled item by item otherwise, which is refused.
        return ReadOnlyTable, (dict(self),)
