"""Parsing of a command's data class with tyro, and its help."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import types
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Union, get_args, get_origin

import tyro
from tyro.constructors import (
    ConstructorRegistry,
    PrimitiveConstructorSpec,
    PrimitiveTypeInfo,
    StructConstructorSpec,
    StructFieldSpec,
    StructTypeInfo,
)

from circumspect.cli.flag_table import REQUIRED, built, flags_of
from circumspect.cli.given_flags import culprit_named

Values = Mapping[Any, Mapping[str, Any]]
"""Class of a command to values of its flags, by name."""


def parse(command: Any, program: str, words: Sequence[str], values: Values | None = None) -> Any:
    """Parse the flags of a command.

    Args:
        command: Data class of the command.
        program: Name of the program in the help.
        words: The flags.
        values: Class of a command to values of flags that are not given, by name; other flags have
            their defaults.

    Raises:
        SystemExit: The flags are wrong (2), or request help (0); the message is printed.
        InputError: A value is invalid.
    """
    return _cli(command, program, words, described(command), values=values)


def described(command: Any) -> str:
    """A command's docstring, with a heading above its examples."""
    # tyro starts a new line before a line that does not begin with a letter.
    return inspect.cleandoc(command.__doc__ or "").replace("\n\n$ ", "\n\nto copy:\n$ ", 1)


def parse_any(commands: Mapping[str, tuple[Any, str]], program: str, words: Sequence[str]) -> Any:
    """Parse the flags of the command that is named by the first word.

    Args:
        commands: Name to data class and summary.
        program: Name of the program in the help.
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
    values: Values | None = None,
) -> Any:
    registry = ConstructorRegistry()
    registry.struct_rule(functools.partial(_flat_struct, values or {}))
    registry.primitive_rule(_optional)
    # A flag that a file switches on can be switched off: both flags exist.
    pairs = () if any((values or {}).values()) else (tyro.conf.FlagCreatePairsOff,)
    return tyro.cli(
        command,
        prog=program,
        args=list(words),
        default=tyro.MISSING_NONPROP,
        description=description,
        config=(*pairs, *markers),
        registry=registry,
    )


def _flat_struct(values: Values, info: StructTypeInfo) -> StructConstructorSpec | None:
    """The flags of a command for tyro, as one flat class without nested settings.

    Help texts are docstrings as flowing text, without empty defaults.
    """
    # tyro wraps a union of commands in a data class of its own.
    wrapper = getattr(info.type, "__module__", "").startswith("tyro.")
    if wrapper or not dataclasses.is_dataclass(info.type):
        return None
    flags, hinted = flags_of(info.type), tyro.conf.arg(help_behavior_hint=_shown_default)
    fields, given = [], values.get(info.type, {})
    for name, flag in flags.items():
        kind: Any = Annotated[_light_hint(flag.hint), hinted]
        default = given.get(name, tyro.MISSING if flag.default is REQUIRED else flag.default)
        # With values of a file, both --NAME and --no-NAME exist.
        text = flag.off if default is True and not any(values.values()) else None
        text = text or flag.help
        fields.append(StructFieldSpec(name=name, type=kind, default=default, helptext=text))

    def instantiate(**parsed: Any) -> Any:
        settings = [flag for flag in flags.values() if len(flag.path) > 1]
        with culprit_named(settings, parsed):
            return built(info.type, parsed)

    return StructConstructorSpec(instantiate=instantiate, fields=tuple(fields))


def _light_hint(hint: Any) -> Any:
    """An equivalent type hint whose defaults tyro checks without typeguard.

    Importing typeguard takes as long as importing NumPy. tyro itself checks `typing.Union` and
    plain classes.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return Annotated[(_light_hint(inner[0]), *inner[1:])]  # pyright: ignore
    if origin in (Union, types.UnionType):
        return Union[tuple(map(_light_hint, inner))]  # noqa: UP007 - put together at run time
    if origin is tuple:
        spec = ConstructorRegistry.get_primitive_spec(PrimitiveTypeInfo.make(hint, set()))
        if isinstance(spec, PrimitiveConstructorSpec):
            # tyro would replace a plain tuple by a tuple of the types of its default.
            return Annotated[object, spec]
    return hint


def _shown_default(default: str) -> str:
    """The default in the help; empty if the help text describes it."""
    return "" if default in ("", "''", "None", "False", "True") else f"(default: {default})"


def _optional(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Show and parse `float | None` as a float."""
    kinds = get_args(info.type)
    if info.type_origin not in (Union, types.UnionType) or types.NoneType not in kinds:
        return None
    given = [kind for kind in kinds if kind is not types.NoneType]
    inner: Any = Union[tuple(given)]  # noqa: UP007 - put together at run time
    spec = ConstructorRegistry.get_primitive_spec(PrimitiveTypeInfo.make(inner, info.markers))
    if not isinstance(spec, PrimitiveConstructorSpec):
        return None
    as_words = spec.str_from_instance
    return dataclasses.replace(
        spec,
        is_instance=lambda value: value is None or spec.is_instance(value),
        str_from_instance=lambda value: [] if value is None else as_words(value),
    )
