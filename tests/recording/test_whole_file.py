from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from circumspect.recording import whole_file
from circumspect.recording.whole_file import WholeFile


def breaks(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """The next write gets half of its bytes onto the disk."""
    write = os.write

    def half(file: int, data: memoryview) -> int:
        monkeypatch.setattr(whole_file.os, "write", write)
        write(file, data[: len(data) // 2])
        raise error

    monkeypatch.setattr(whole_file.os, "write", half)


@pytest.fixture
def begun(tmp_path: Path) -> WholeFile:
    """A file that holds one record, and a second one that is to be kept."""
    file = WholeFile(tmp_path / "records")
    file.write(b"one")
    file.keep()
    file.write(b"second")
    return file


def test_what_is_interrupted_is_written_once_when_it_is_kept_again(
    begun: WholeFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(monkeypatch, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        begun.keep()
    assert (tmp_path / "records").read_bytes() == b"one"
    begun.write(b"third")
    begun.keep()
    assert begun.tell() == len(b"onesecondthird")
    begun.close()
    assert (tmp_path / "records").read_bytes() == b"onesecondthird"


def test_what_the_system_refuses_is_cut_off_and_ends_it(
    begun: WholeFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(monkeypatch, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with pytest.raises(OSError, match="space"):
        begun.keep()
    assert begun.closed
    assert (tmp_path / "records").read_bytes() == b"one"
