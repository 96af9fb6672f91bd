"""The flags of a command: the fields of its data class and of nested settings."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self, get_args, get_origin, get_type_hints

REQUIRED: Any = object()
"""Marks a flag without a default."""


class Flags:
    """Annotation of nested settings that selects which attributes are flags.

    Without it, all attributes are flags under their own names.
    """

    def __init__(self, *names: str, **renamed: str) -> None:
        """Select attributes.

        Args:
            names: Attributes that are flags under their own names.
            renamed: Attribute to the name of its flag.
        """
        self._names: dict[str, str] = {name: name for name in names} | renamed
        self._others = False

    @classmethod
    def every(cls, **renamed: str) -> Self:
        """Select all attributes, some of them under other names.

        Args:
            renamed: Attribute to the name of its flag.
        """
        made = cls(**renamed)
        made._others = True
        return made

    def name_of(self, attribute: str) -> str | None:
        """The name of an attribute's flag; None if it has no flag."""
        return self._names.get(attribute, attribute if self._others else None)


@dataclass(frozen=True)
class Flag:
    """A flag of a command.

    Attributes:
        name: Name with underscores and without leading dashes.
        path: Attributes from the command to the value.
        hint: Type hint of the value.
        default: Default value, or `REQUIRED`.
        help: Help text; None if there is none.
        off: Help text of --no-NAME for a flag that is on by default; None means `help`.
    """

    name: str
    path: tuple[str, ...]
    hint: Any
    default: Any
    help: str | None
    off: str | None = None

    @property
    def typed(self) -> str:
        """The flag as it is typed, such as --yaw-count."""
        return f"--{self.name.replace('_', '-')}"

    def value(self, command: Any) -> Any:
        """The value of the flag in a command."""
        for name in self.path:
            command = getattr(command, name)
        return command


@functools.cache
def flags_of(kind: Any) -> Mapping[str, Flag]:
    """Name to flag, in the order of fields.

    Fields that are data classes are settings: their fields are also flags of the command. The
    default of the field contains the defaults of these flags.

    Args:
        kind: Data class of a command.
    """
    found = list(_flags(kind, None, (), Flags.every()))
    flags = {flag.name: flag for flag in found}
    assert len(flags) == len(found), "two settings of a command have a flag of the same name"
    return flags


def _flags(kind: Any, preset: Any, path: tuple[str, ...], chosen: Flags) -> Iterator[Flag]:
    """The flags of a data class.

    Args:
        kind: The data class.
        preset: Instance with the defaults; None means the defaults of the class.
        path: Attributes from the command to the data class.
        chosen: Selection of attributes that are flags.
    """
    hints, texts = get_type_hints(kind, include_extras=True), _texts(kind)
    for field in dataclasses.fields(kind):
        name, hint = field.name, hints[field.name]
        default = _default(field) if preset is None else getattr(preset, name)
        called = chosen.name_of(name)
        if settings := settings_of(hint):
            yield from _flags(settings, default, (*path, name), _chosen(hint))
        elif called is not None:
            off = field.metadata.get("off")
            place = (*path, name)
            yield Flag(called.strip("_"), place, hint, default, texts.get(name), off)


def settings_of(hint: Any) -> Any:
    """The data class of a field that holds settings; None for other fields."""
    kind = get_args(hint)[0] if get_origin(hint) is Annotated else hint
    return kind if isinstance(kind, type) and dataclasses.is_dataclass(kind) else None


def _chosen(hint: Any) -> Flags:
    marks = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    return next((mark for mark in marks if isinstance(mark, Flags)), Flags.every())


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return REQUIRED if field.default is dataclasses.MISSING else field.default


def _texts(kind: Any) -> dict[str, str]:
    """Attribute to its docstring as flowing text."""
    import docstring_parser

    return {
        entry.arg_name: " ".join((entry.description or "").split())
        for entry in docstring_parser.parse_from_object(kind).params
    }


def built(kind: Any, values: Mapping[str, Any]) -> Any:
    """Build a command with its settings.

    Args:
        kind: Its data class.
        values: Values of all its flags, by name.

    Raises:
        InputError: A value is invalid.
    """
    nested: dict[str, Any] = {}
    for flag in flags_of(kind).values():
        place = nested
        for name in flag.path[:-1]:
            place = place.setdefault(name, {})
        place[flag.path[-1]] = values[flag.name]
    return kind(**_with_settings(kind, None, nested))


def _with_settings(kind: Any, preset: Any, nested: Mapping[str, Any]) -> dict[str, Any]:
    """The values of fields, with mappings converted to instances of settings."""
    hints, found = get_type_hints(kind, include_extras=True), dict(nested)
    for field in dataclasses.fields(kind):
        if settings := settings_of(hints[field.name]):
            default = _default(field) if preset is None else getattr(preset, field.name)
            own = _with_settings(settings, default, nested.get(field.name, {}))
            found[field.name] = dataclasses.replace(default, **own)
    return found
