"""A downloader for pooch that goes on where an earlier attempt broke off."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.errors import CircumspectError, InputError

if TYPE_CHECKING:
    from requests import Response

CHUNK = 1 << 16
TIMEOUT = 30.0
"""Without a byte for so long [s] an attempt is over."""
PARTIAL, PAST_THE_END = 206, 416
NUMBER = re.compile(r"[0-9]{1,18}")
SPAN = re.compile(r"bytes (?P<first>[0-9]{1,18})-[0-9]+/(?P<total>[0-9]{1,18})?")
"""What a part of a body is called: first, last and all; all may be *."""


class ResumedDownload:
    """Keeps what has come beside the target and asks only for the rest.

    Args:
        part: Where to keep what has come; a second file beside it tells the version of it. Once
            all has come it is called .whole until it is at the target.
        attempts: How often to go on after the connection broke without a further byte.
        pause: Before the second attempt [s]; it doubles from attempt to attempt.
        progress: Called with (bytes there, bytes in all).
    """

    def __init__(
        self,
        part: Path,
        attempts: int = 5,
        pause: float = 1.0,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        self.part, self.attempts, self.pause, self.progress = part, attempts, pause, progress
        self._version = part.with_suffix(part.suffix + ".version")
        self._whole = part.with_suffix(".whole")

    def __call__(self, url: str, output_file: Any, pooch: Any, **_: Any) -> None:  # noqa: ARG002
        """Download; the signature is pooch's.

        Raises:
            InputError: It is no address of a file.
            CircumspectError: The server can not be reached, refuses, or breaks off too often.
            OSError: The disk fails; what has come stays for the next attempt.
        """
        if not self._whole.exists():
            self._download(url)
            self.part.replace(self._whole)
        self._version.unlink(missing_ok=True)
        # Renamed on the same disk, so that it needs no room twice.
        shutil.move(self._whole, output_file)

    def _download(self, url: str) -> None:
        """Bring all of it into the part."""
        failures, most = 0, 0
        while (reason := self._attempt(url)) is not None:
            there = self._there()
            # What comes again after it was discarded is no progress, or this might never end.
            failures = 1 if there > most else failures + 1
            most = max(most, there)
            if failures >= self.attempts:
                raise CircumspectError(
                    f"{url}: can not be fetched ({reason}); the same command goes on with the "
                    f"{there:,} bytes that are there"
                )
            time.sleep(self.pause * 2 ** (failures - 1))

    def _attempt(self, url: str) -> str | None:
        """Bring what is missing; why it has not all come, None where it has."""
        import requests
        from requests.exceptions import InvalidSchema, InvalidURL, MissingSchema

        try:
            return self._went_on(url)
        except requests.HTTPError as error:
            status = "nothing" if error.response is None else error.response.status_code
            raise CircumspectError(f"{url}: the server answers {status}") from error
        except (MissingSchema, InvalidSchema, InvalidURL) as error:
            raise InputError(
                f"{url}: is no address to fetch from; give one like https://HOST/ModelNet10.zip"
            ) from error
        except requests.RequestException as error:
            return type(error).__name__

    def _there(self) -> int:
        return self.part.stat().st_size if self.part.exists() else 0

    def _went_on(self, url: str) -> str | None:
        """Ask for what is missing; why it has not all come, None where it has."""
        import requests

        there, headers = self._there(), {"Accept-Encoding": "identity"}
        if there and self._version.exists():
            headers |= {
                "Range": f"bytes={there}-",
                # Otherwise parts of two versions would become one file.
                "If-Range": self._version.read_text(encoding="latin-1"),
            }
        else:
            there = 0
        with requests.get(url, headers=headers, stream=True, timeout=TIMEOUT) as answer:
            if answer.status_code == PAST_THE_END or _starts_elsewhere(answer, there):
                self.part.unlink(missing_ok=True)
                return "the server does not go on where it broke off"
            answer.raise_for_status()
            if answer.status_code != PARTIAL:
                there = 0
            return self._received(url, answer, there)

    def _received(self, url: str, answer: Response, there: int) -> str | None:
        """Put an answer's body behind the bytes that are there; as `_went_on`."""
        total = _total(answer, there)
        self.part.parent.mkdir(parents=True, exist_ok=True)
        self._require_space(url, 0 if total is None else total - there)
        self._keep_version(_version(answer))
        with self.part.open("ab" if there else "wb") as stream:
            for chunk in answer.iter_content(CHUNK):
                stream.write(chunk)
                there += len(chunk)
                if self.progress:
                    self.progress(there, total or there)
        return None if total is None or there == total else "the connection broke"

    def _keep_version(self, version: str | None) -> None:
        if version is None:
            self._version.unlink(missing_ok=True)
        else:
            # As headers are; any bytes are some version.
            self._version.write_text(version, encoding="latin-1")

    def _require_space(self, url: str, missing: int) -> None:
        free = shutil.disk_usage(os.fspath(self.part.parent)).free
        if missing > free:
            raise CircumspectError(
                f"{url}: {missing / 1e6:,.0f} MB are to come, but {self.part.parent} has room for "
                f"{free / 1e6:,.0f} MB"
            )


def _packed(answer: Response) -> bool:
    """A body that is unpacked on its way here, though it was asked for as it is."""
    return answer.headers.get("Content-Encoding", "identity") != "identity"


def _starts_elsewhere(answer: Response, there: int) -> bool:
    """A part that does not begin behind the bytes that are there, or does not say where."""
    if answer.status_code != PARTIAL:
        return False
    span = SPAN.match(answer.headers.get("Content-Range", ""))
    return span is None or int(span["first"]) != there or _packed(answer)


def _total(answer: Response, there: int) -> int | None:
    """How many bytes there will be in all; None where that is not known."""
    if answer.status_code == PARTIAL:
        # A server may send less than was asked for: all is what it says of all.
        span = SPAN.match(answer.headers.get("Content-Range", ""))
        if span and span["total"]:
            return int(span["total"])
    length = answer.headers.get("Content-Length", "")
    # Where a server sends other words, the body ends when the connection does.
    return None if _packed(answer) or not NUMBER.fullmatch(length) else there + int(length)


def _version(answer: Response) -> str | None:
    """By what the rest of the same version can be asked for; None where it can not."""
    version = answer.headers.get("ETag") or answer.headers.get("Last-Modified")
    # Ranges of a packed body do not count the bytes that are there.
    weak = version is None or version.startswith("W/")
    return None if weak or _packed(answer) else version
