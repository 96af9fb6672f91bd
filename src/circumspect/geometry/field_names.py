"""Names of columns, where a file may use one several times."""

from __future__ import annotations

from collections.abc import Collection, Sequence

COORDINATES = ("x", "y", "z")


def unique_names(names: Sequence[str], needed: Collection[str] = COORDINATES) -> tuple[str, ...]:
    """The names with a number behind each further use of one, as "intensity 2".

    Args:
        names: As in the header.
        needed: Names that have to be unambiguous.

    Raises:
        ValueError: One of the needed names stands twice.
    """
    uses: dict[str, int] = {}
    unique = []
    for name in names:
        uses[name] = uses.get(name, 0) + 1
        if uses[name] == 1:
            unique.append(name)
            continue
        if name in needed:
            raise ValueError(f"{name!r} stands twice")
        unique.append(f"{name} {uses[name]}")
    return tuple(unique)
