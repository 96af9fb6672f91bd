"""`--config FILE`: reading values of flags from a file, and writing those of a run."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import tyro

from circumspect import __version__
from circumspect.cli.flag_table import Flag, flags_of
from circumspect.cli.typed_values import WrongTypeError, typed_value
from circumspect.errors import InputError, OutputError, printable, reason_of

CONFIG = "config.toml"
"""Name of the file in the folder of a run: its flags, with randomly drawn values."""
SIGN = b"# circumspect "
"""First bytes of a file written by a run; other files of this name are not replaced."""
MAX_BYTES = 2**20
"""Maximum size of a file [bytes]; larger files are not config files."""
MAX_SHOWN = 40
"""Maximum length of a key or a value in a message [characters]."""
YAML = (".yaml", ".yml")

ConfigFlag = Annotated[
    Path | None,
    tyro.conf.arg(
        metavar="FILE",
        help="TOML or YAML file with values of these flags by name, such as the config.toml that a "
        "run writes. Flags override it.",
    ),
]
"""The flag `--config` of long-running commands."""


def early_value(words: Sequence[str], name: str) -> str | None:
    """The value of a flag before all flags are parsed; None if it is not given.

    Args:
        words: The flags.
        name: Name of the flag, with underscores.
    """
    found = None
    for word, following in zip_longest(words, words[1:]):
        if word == "--":
            break
        flag, equals, value = word.partition("=")
        if flag.startswith("--") and flag[2:].replace("-", "_") == name:
            found = value if equals else following
    return found


def values_of_files(kind: Any, words: Sequence[str]) -> dict[str, Any]:
    """The values in the file of `--config`; empty without that flag.

    Args:
        kind: The data class of the command.
        words: Flags of the command.

    Returns:
        See `read_config`.

    Raises:
        InputError: See `read_config`.
        MissingExtraError: See `read_config`.
    """
    path = early_value(words, "config") if "config" in flags_of(kind) else None
    return {} if path is None else read_config(Path(path), kind)


def read_config(path: Path, kind: Any) -> dict[str, Any]:
    """Read values of a command's flags from a file.

    Args:
        path: YAML file by its suffix, TOML otherwise. Keys are names of flags, with dashes or
            underscores. They may be in a table named after their group of settings.
        kind: The data class of the command.

    Returns:
        Flag to value.

    Raises:
        InputError: It can not be read, or has an unknown key or a value of a wrong type.
        MissingExtraError: PyYAML is not installed.
    """
    flags = {name: flag for name, flag in flags_of(kind).items() if name != "config"}
    found: dict[str, Any] = {}
    for key, table, value in _entries(_document(path), flags):
        flag, negated = _flag_of(key.replace("-", "_"), flags)
        if flag is None or table not in (None, flag.path[0]):
            where = "" if table is None else f" in [{table}]"
            raise InputError(
                f"{path}: no key {_abbreviated(key)}{where}; {_known_keys(key, table, flags)}"
            )
        if flag.name in found:
            raise InputError(f"{path}: {flag.name} is given twice")
        try:
            typed = typed_value(flag.hint, value)
        except WrongTypeError as error:
            raise InputError(
                f"{path}: {flag.name} is {error}, not {_abbreviated(value)}"
            ) from error
        found[flag.name] = not typed if negated else typed
    return found


def _flag_of(name: str, flags: Mapping[str, Flag]) -> tuple[Flag | None, bool]:
    """The flag of a key, and whether the key negates it: no_NAME."""
    if name in flags or not name.startswith("no_"):
        return flags.get(name), False
    flag = flags.get(name.removeprefix("no_"))
    return (flag if flag is not None and flag.hint is bool else None), True


def _entries(
    document: Mapping[Any, Any], flags: Mapping[str, Flag]
) -> Iterator[tuple[str, str | None, Any]]:
    """Key, table and value of each entry of a document."""
    tables = {flag.path[0] for flag in flags.values() if len(flag.path) > 1}
    for key, value in document.items():
        table = str(key).replace("-", "_")
        if isinstance(value, Mapping) and table in tables and table not in flags:
            yield from ((str(own), table, one) for own, one in value.items())
        else:
            yield str(key), None, value


def _known_keys(name: str, table: str | None, flags: Mapping[str, Flag]) -> str:
    """The known keys of a table or of the whole file, or a similar one, in words."""
    keys = [flag.name for flag in flags.values() if table in (None, flag.path[0])]
    near = difflib.get_close_matches(name, keys, 1)
    return f"did you mean {near[0]}?" if near else f"known: {', '.join(keys)}"


def _abbreviated(value: Any) -> str:
    """The first characters of a key or a value, for a message."""
    try:
        return repr(value[:MAX_SHOWN]) if isinstance(value, str) else str(value)[:MAX_SHOWN]
    except ValueError:  # Python does not print numbers with thousands of digits.
        return "a long number"


def _document(path: Path) -> Mapping[Any, Any]:
    if path.suffix.lower() in YAML:
        from circumspect.sensing.untrusted_files import read_yaml

        document = read_yaml(path, MAX_BYTES, "a config file", "ros2")
    else:
        document = _toml(path)
    if document is None:
        return {}
    if not isinstance(document, Mapping):
        raise InputError(f"{path}: holds no keys and values")
    return document


def _toml(path: Path) -> dict[str, Any]:
    import tomllib

    try:
        if not path.is_file():
            raise InputError(f"{path}: is no file" if path.exists() else f"{path}: no such file")
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: can not be read ({reason_of(error)})") from error
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: has more than {MAX_BYTES} bytes; is it a config file?")
    try:
        return tomllib.loads(data.decode())
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no TOML ({printable(str(error))})") from error


def write_config(folder: Path, command: Any, name: str, **drawn: Any) -> None:
    """Write the values of a command's flags to the folder of its run, for `--config`.

    Args:
        folder: Folder of the run.
        command: The parsed command.
        name: Name of the command, such as "locate simulate".
        drawn: Randomly drawn values of flags.

    Raises:
        OutputError: It can not be written, or would replace a file that no run wrote.
    """
    from circumspect.storage import atomic_open

    path = Path(folder) / CONFIG
    if not _is_own(path):
        raise OutputError(f"{path}: is of no run and would be replaced; take another folder")
    with atomic_open(path) as stream:
        stream.write(config_text(command, name, **drawn))


def write_config_to(place: str, command: Any, name: str) -> None:
    """Like `write_config`, to a folder or the URL of an object store.

    Raises:
        OutputError: See `write_config`.
    """
    if "://" not in place:
        write_config(Path(place), command, name)
        return
    from circumspect.datasets.set_store import SetStore

    SetStore(place).write(CONFIG, config_text(command, name).encode())


def _is_own(path: Path) -> bool:
    """Whether a run may write a file: it does not exist, or an earlier run wrote it."""
    try:
        with path.open("rb") as stream:
            return stream.read(len(SIGN)) == SIGN
    except FileNotFoundError:
        return True
    except OSError as error:
        raise OutputError(f"{path}: can not be written ({reason_of(error)})") from error


def config_text(command: Any, name: str, **drawn: Any) -> str:
    """The text that `write_config` writes."""
    lines = [f"{SIGN.decode()}{__version__}: circumspect {name} --config FILE does this again"]
    for flag in flags_of(type(command)).values():
        value = drawn.get(flag.name, flag.value(command))
        if value is not None and flag.name != "config":
            lines.append(_line(flag.name, value))
    return "\n".join(lines) + "\n"


def _line(name: str, value: Any) -> str:
    line = f"{name} = {_toml_value(value)}"
    try:
        line.encode()
    except UnicodeEncodeError:  # A path with bytes that are not UTF-8.
        return f"# {line!a}"
    return line


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    # TOML has the escapes of JSON, but also requires one for this character.
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
