"""A downloader for pooch that resumes interrupted downloads."""

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
"""Time without a byte after which an attempt ends [s]."""
PARTIAL, PAST_THE_END = 206, 416
NUMBER = re.compile(r"[0-9]{1,18}")
SPAN = re.compile(r"bytes (?P<first>[0-9]{1,18})-[0-9]+/(?P<total>[0-9]{1,18})?")
"""Content-Range header: first, last and total; each may be *."""


class ResumedDownload:
    """Downloader that keeps the received bytes and requests only the rest.

    Args:
        part: File of the received bytes; a second file beside it contains their version. A complete
            download is named .whole until it is moved to the target.
        attempts: Number of retries after the connection broke without a further byte.
        pause: Pause before the second attempt [s]; doubled for each further one.
        progress: Called with (received bytes, all bytes).
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
            InputError: The URL is not the address of a file.
            CircumspectError: The server is unreachable, refuses, or closes the connection too
                often.
            OSError: The disk fails; the received bytes are kept for the next attempt.
        """
        if not self._whole.exists():
            self._download(url)
            self.part.replace(self._whole)
        self._version.unlink(missing_ok=True)
        # A rename on the same disk needs no further space.
        shutil.move(self._whole, output_file)

    def _download(self, url: str) -> None:
        """Download everything into the part."""
        failures, most = 0, 0
        while (reason := self._attempt(url)) is not None:
            there = self._there()
            # Bytes received again after they were discarded are no progress; this prevents an
            # endless loop.
            failures = 1 if there > most else failures + 1
            most = max(most, there)
            if failures >= self.attempts:
                raise CircumspectError(
                    f"{url}: can not be fetched ({reason}); the same command resumes with the "
                    f"{there:,} bytes that are there"
                )
            time.sleep(self.pause * 2 ** (failures - 1))

    def _attempt(self, url: str) -> str | None:
        """Download the missing bytes; return why some are still missing, or None."""
        import requests
        from requests.exceptions import InvalidSchema, InvalidURL, MissingSchema

        try:
            return self._continued(url)
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

    def _continued(self, url: str) -> str | None:
        """Request the missing bytes; return why some are still missing, or None."""
        import requests

        there, headers = self._there(), {"Accept-Encoding": "identity"}
        if there and self._version.exists():
            headers |= {
                "Range": f"bytes={there}-",
                # Otherwise parts of two versions could be combined.
                "If-Range": self._version.read_text(encoding="latin-1"),
            }
        else:
            there = 0
        with requests.get(url, headers=headers, stream=True, timeout=TIMEOUT) as answer:
            if answer.status_code == PAST_THE_END or _starts_elsewhere(answer, there):
                self.part.unlink(missing_ok=True)
                return "the server does not resume where it broke off"
            answer.raise_for_status()
            if answer.status_code != PARTIAL:
                there = 0
            return self._received(url, answer, there)

    def _received(self, url: str, answer: Response, there: int) -> str | None:
        """Append an answer's body to the part; return as `_continued`."""
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
            # The encoding of headers, which accepts any bytes.
            self._version.write_text(version, encoding="latin-1")

    def _require_space(self, url: str, missing: int) -> None:
        free = shutil.disk_usage(os.fspath(self.part.parent)).free
        if missing > free:
            raise CircumspectError(
                f"{url}: {missing / 1e6:,.0f} MB are to come, but {self.part.parent} has room for "
                f"{free / 1e6:,.0f} MB"
            )


def _packed(answer: Response) -> bool:
    """Whether a body is compressed in transit, although it was requested uncompressed."""
    return answer.headers.get("Content-Encoding", "identity") != "identity"


def _starts_elsewhere(answer: Response, there: int) -> bool:
    """Whether a part does not continue the received bytes, or does not state its range."""
    if answer.status_code != PARTIAL:
        return False
    span = SPAN.match(answer.headers.get("Content-Range", ""))
    return span is None or int(span["first"]) != there or _packed(answer)


def _total(answer: Response, there: int) -> int | None:
    """Total number of bytes; None if unknown."""
    if answer.status_code == PARTIAL:
        # A server may send less than was requested; its total counts.
        span = SPAN.match(answer.headers.get("Content-Range", ""))
        if span and span["total"]:
            return int(span["total"])
    length = answer.headers.get("Content-Length", "")
    # Without a length, the body ends with the connection.
    return None if _packed(answer) or not NUMBER.fullmatch(length) else there + int(length)


def _version(answer: Response) -> str | None:
    """The validator of this version for a range request; None if there is none."""
    version = answer.headers.get("ETag") or answer.headers.get("Last-Modified")
    # Ranges of a compressed body do not count the received bytes.
    weak = version is None or version.startswith("W/")
    return None if weak or _packed(answer) else version
