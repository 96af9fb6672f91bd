"""The exception tree: every error that a user can fix is a `CircumspectError`."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_log = logging.getLogger(__name__)


class CircumspectError(Exception):
    """Base of all known errors; its message is one line that names cause and remedy."""


class InputError(CircumspectError):
    """A given file or array cannot be used."""


class GeometryError(InputError):
    """Points or faces that span no shape: too few, all equal, on a line, not finite."""


class WeightsError(InputError):
    """Weights that are broken or belong to another network or to other classes."""


class OutputError(CircumspectError):
    """A result could not be written; no incomplete file is left."""


class MissingExtraError(CircumspectError):
    """An optional dependency is not installed; the message says how to get it."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(
            f'{package} is not installed; get it with: pip install "circumspect[{extra}]"'
        )
        self.package, self.extra = package, extra

    def __reduce__(self) -> tuple[type[MissingExtraError], tuple[str, str]]:
        # It must be picklable, since it may come from another process.
        return MissingExtraError, (self.package, self.extra)


def reason_of(error: OSError) -> str:
    """The reason in the system's own words, for the middle of a sentence."""
    return (error.strerror or str(error)).lower()


def printable(text: str) -> str:
    """Untrusted text without line breaks and terminal control characters."""
    return "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in text)


@contextmanager
def naming_file(file: Path) -> Iterator[None]:
    """Convert errors with a file to known errors that name it.

    Other files are still processed. The traceback of an unknown error, which is one of circumspect,
    is logged at the level DEBUG.

    Raises:
        CircumspectError: Any error except a closed pipe or connection.
    """
    try:
        yield
    except CircumspectError as error:
        if str(error).startswith(f"{file}:"):
            raise
        raise CircumspectError(f"{file}: {error}") from error
    except ConnectionError:
        raise
    except MemoryError as error:
        raise CircumspectError(f"{file}: does not fit into memory; thin it out first") from error
    except OSError as error:
        raise CircumspectError(f"{file}: can not be read ({reason_of(error)})") from error
    except Exception as error:
        _log.debug("%s", file, exc_info=True)
        what = f"{type(error).__name__}: {str(error)[:200]}".partition("\n")[0]
        raise CircumspectError(
            f"{file}: can not be used ({what}); please report this, with the file"
        ) from error
