"""Networks, view planners and readers by name: built in, or from other packages.

A package offers one by an entry point. Code that is not installed is named MODULE:NAME. No module
is imported and no installed package is inspected before a name is looked up that is not built in.
"""

from __future__ import annotations

import difflib
import re
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from circumspect.errors import InputError, printable

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

T = TypeVar("T")
REFERENCE = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*")
"""Pattern of MODULE:NAME, an object in a Python module."""
PLUGIN_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,63}")
"""Pattern of a plug-in's name; it may also name a folder."""
MAX_CAUSE = 300
"""Largest length of the cause in a message [characters]."""


class PluginError(InputError):
    """A plug-in that cannot be used; the message names it and the cause."""


@dataclass(frozen=True)
class Plugin:
    """An entry point that an installed package offers.

    Attributes:
        kind: Its kind, such as "network".
        name: Of the entry point.
        reference: MODULE:NAME of the object.
        distribution: Name and version of the package.
        error: Why it cannot be used; None if it can.
    """

    kind: str
    name: str
    reference: str
    distribution: str
    error: str | None

    def to_dict(self) -> dict[str, str | None]:
        """JSON types."""
        return asdict(self)


class Registry(Generic[T]):
    """Looks up objects of one kind by name."""

    def __init__(
        self, kind: str, group: str, built_in: Mapping[str, T], checked: Callable[[str, Any], T]
    ) -> None:
        """Create the registry; nothing is loaded yet.

        Args:
            kind: The kind for messages, such as "network".
            group: Of the entry points.
            built_in: By name; they take precedence over plug-ins.
            checked: Takes the name and the object of a plug-in. Returns the object if it has the
                right kind, else raises an `InputError` that says what it is and what is needed.
        """
        self.kind, self.group, self.built_in = kind, group, built_in
        self._checked = checked
        self._loaded: dict[str, T] = {}
        self._entries: dict[str, list[EntryPoint]] | None = None

    def get(self, name: str) -> T:
        """Look up an object and load it.

        Args:
            name: Built in, of an entry point, or MODULE:NAME. The module may lie in the current
                folder.

        Raises:
            InputError: There is none of that name.
            PluginError: It cannot be loaded, or is of the wrong kind.
        """
        if (found := self.find(name)) is not None:
            return found
        known = self.names()
        near = difflib.get_close_matches(name, known, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise InputError(
            f"no {self.kind} '{printable(name[:80])}'; known: {', '.join(known)}{hint}"
        )

    def find(self, name: str, *, reference: bool = True) -> T | None:
        """The same, but None for an unknown name.

        Args:
            name: See `get`.
            reference: Whether it may be MODULE:NAME. False for a name from a file: its author must
                not choose what code is imported.

        Raises:
            PluginError: See `get`.
        """
        if not reference and REFERENCE.fullmatch(name):
            return None
        if name in self.built_in:
            return self.built_in[name]
        if name in self._loaded:
            return self._loaded[name]
        if REFERENCE.fullmatch(name):
            from importlib.metadata import EntryPoint

            entry, origin = EntryPoint(name, name, self.group), ""
            if (here := str(Path.cwd())) not in sys.path:
                # Last: a file there never replaces an installed package.
                sys.path.append(here)
        else:
            offered = self._offered().get(name, [])
            if not offered:
                return None
            if len(offered) > 1:
                both = " and ".join(map(_distribution, offered))
                raise PluginError(f"{self.kind} '{name}': offered by {both}; uninstall one")
            entry, origin = offered[0], f" of {_distribution(offered[0])}"
        value = self._loaded[name] = self._load(name, entry, origin)
        return value

    def remember(self, name: str, value: T) -> None:
        """Register an object under a further name in this process.

        Raises:
            PluginError: The name is built in.
        """
        if name in self.built_in:
            raise PluginError(f"{self.kind} '{name}': the name of a built-in one; choose another")
        self._loaded[name] = value

    def names(self) -> tuple[str, ...]:
        """All names except MODULE:NAME: built-in ones, then plug-ins; nothing is imported."""
        loaded = (name for name in self._loaded if not REFERENCE.fullmatch(name))
        return tuple(dict.fromkeys((*self.built_in, *loaded, *sorted(self._offered()))))

    def plugins(self) -> list[Plugin]:
        """Load all plug-ins of installed packages, and report which of them can be used."""
        return [
            Plugin(self.kind, name, entry.value, _distribution(entry), self._error_of(name))
            for name, entries in sorted(self._offered().items())
            for entry in entries
        ]

    def _error_of(self, name: str) -> str | None:
        if name in self.built_in:
            return f"{self.kind} '{name}': the name of a built-in one; choose another"
        try:
            self.get(name)
        except InputError as error:
            return str(error)
        return None

    def forget(self) -> None:
        """Forget all plug-ins, after packages were installed or removed."""
        self._loaded.clear()
        self._entries = None

    def _offered(self) -> dict[str, list[EntryPoint]]:
        if self._entries is None:
            self._entries = self._found()
        return self._entries

    def _found(self) -> dict[str, list[EntryPoint]]:
        # Imported here, since it would delay every command.
        from importlib.metadata import entry_points

        found: dict[str, list[EntryPoint]] = {}
        for entry in entry_points(group=self.group):
            # A package that is found twice on the path offers the same object twice.
            same = [other for other in found.get(entry.name, []) if other.value == entry.value]
            if not same:
                found.setdefault(entry.name, []).append(entry)
        return found

    def _load(self, name: str, entry: EntryPoint, origin: str) -> T:
        """Load the object of an entry point.

        Raises:
            PluginError: See `get`.
        """
        title = f"{self.kind} '{printable(name)}'{origin}"
        try:
            value = entry.load()
        # A module may raise anything, or exit, while it is imported.
        except (Exception, SystemExit) as error:
            raise PluginError(f"{title} can not be loaded: {cause_of(error)}") from error
        try:
            return self._checked(name, value)
        except InputError as error:
            raise PluginError(f"{title} {error}") from error


def cause_of(error: BaseException) -> str:
    """An exception of third-party code in one line: its type, message and origin."""
    frames = traceback.extract_tb(error.__traceback__)
    at = f" ({frames[-1].filename}:{frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())[:MAX_CAUSE]
    return printable(f"{type(error).__name__}: {text}{at}" if text else type(error).__name__ + at)


def kind_of(value: Any) -> str:
    """Description of a wrong object: "is the class Net", "is an object of the class str"."""
    if isinstance(value, type):
        return f"is the class {value.__name__}"
    return f"is an object of the class {type(value).__name__}"


def _distribution(entry: EntryPoint) -> str:
    """Name and version of the package that offers an entry point."""
    if entry.dist is None:
        return "an unknown package"
    return printable(f"{entry.dist.name} {entry.dist.version}")
