"""How a command's data class becomes flags: parsed by tyro, explained in plain words."""

from __future__ import annotations

import dataclasses
import inspect
import types
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Union, get_args, get_type_hints

import docstring_parser
import tyro
from tyro.constructors import (
    ConstructorRegistry,
    PrimitiveConstructorSpec,
    PrimitiveTypeInfo,
    StructConstructorSpec,
    StructFieldSpec,
    StructTypeInfo,
)


def parse(command: Any, program: str, words: Sequence[str], preset: Any = None) -> Any:
    """A command with its flags.

    Args:
        command: A data class.
        program: What the help calls it.
        words: The flags.
        preset: A command whose values stand where no flag is given; None for its defaults.

    Raises:
        SystemExit: The flags are wrong (2), or ask for help (0); it has been told.
    """
    return _cli(command, program, words, described(command), preset=preset)


def described(command: Any) -> str:
    """A command's docstring, its lines to copy below a heading."""
    # tyro sets a line that begins with no letter off by a line of its own.
    return inspect.cleandoc(command.__doc__ or "").replace("\n\n$ ", "\n\nto copy:\n$ ", 1)


def parse_any(commands: Mapping[str, tuple[Any, str]], program: str, words: Sequence[str]) -> Any:
    """The same where the first word says which of several commands.

    Args:
        commands: Name to data class and summary.
        program: What the help calls it.
        words: The command and its flags.

    Raises:
        SystemExit: See `parse`.
    """
    kinds = [
        Annotated[kind, tyro.conf.subcommand(name, description=summary)]
        for name, (kind, summary) in commands.items()
    ]
    markers = (tyro.conf.OmitArgPrefixes, tyro.conf.OmitSubcommandPrefixes)
    return _cli(Union[tuple(kinds)], program, words, None, *markers)  # noqa: UP007


def _cli(
    command: Any,
    program: str,
    words: Sequence[str],
    description: str | None,
    *markers: Any,
    preset: Any = None,
) -> Any:
    registry = ConstructorRegistry()
    registry.struct_rule(_explained)
    registry.primitive_rule(_optional)
    return tyro.cli(
        command,
        prog=program,
        args=list(words),
        default=tyro.MISSING_NONPROP if preset is None else preset,
        description=description,
        config=(tyro.conf.FlagCreatePairsOff, *markers),
        registry=registry,
    )


def _explained(info: StructTypeInfo) -> StructConstructorSpec | None:
    """Fields as they are, with their docstrings as flowing text and no word on empty defaults."""
    # A union of commands comes wrapped in a data class of tyro's own.
    wrapper = getattr(info.type, "__module__", "").startswith("tyro.")
    if wrapper or not dataclasses.is_dataclass(info.type):
        return None
    hints = get_type_hints(info.type, include_extras=True)
    told = {
        entry.arg_name: " ".join((entry.description or "").split())
        for entry in docstring_parser.parse_from_object(info.type).params
    }
    hinted = tyro.conf.arg(help_behavior_hint=_hint)
    kinds: dict[str, Any] = {name: Annotated[hint, hinted] for name, hint in hints.items()}
    fields = []
    for field in dataclasses.fields(info.type):
        name, default = field.name, _default(field, info.default)
        text = _helptext(field, default, told.get(name))
        fields.append(StructFieldSpec(name=name, type=kinds[name], default=default, helptext=text))
    return StructConstructorSpec(instantiate=info.type, fields=tuple(fields))


def _helptext(field: dataclasses.Field[Any], default: Any, told: str | None) -> str | None:
    """What its docstring says, or of a flag --no-NAME what the field's metadata says of that."""
    return field.metadata.get("off", told) if default is True else told


def _default(field: dataclasses.Field[Any], preset: Any) -> Any:
    if dataclasses.is_dataclass(preset):
        return getattr(preset, field.name)
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return tyro.MISSING if field.default is dataclasses.MISSING else field.default


def _hint(default: str) -> str:
    """What the help says of a default; the text tells what happens without a flag."""
    return "" if default in ("", "''", "None", "False", "True") else f"(default: {default})"


def _optional(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """`float | None` is asked for as a float: nobody types None."""
    kinds = get_args(info.type)
    if info.type_origin not in (Union, types.UnionType) or types.NoneType not in kinds:
        return None
    given = [kind for kind in kinds if kind is not types.NoneType]
    inner: Any = Union[tuple(given)]  # noqa: UP007 - put together at run time
    spec = ConstructorRegistry.get_primitive_spec(PrimitiveTypeInfo.make(inner, info.markers))
    if not isinstance(spec, PrimitiveConstructorSpec):
        return None
    told = spec.str_from_instance
    return dataclasses.replace(
        spec,
        is_instance=lambda value: value is None or spec.is_instance(value),
        str_from_instance=lambda value: [] if value is None else told(value),
    )
