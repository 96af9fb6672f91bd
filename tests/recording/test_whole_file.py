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


def test_what_is_interrupted_is_written_once_when_it_is_kept_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = WholeFile(tmp_path / "records")
    file.write(b"one")
    file.keep()
    file.write(b"second")
    breaks(monkeypatch, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        file.keep()
    assert (tmp_path / "records").read_bytes() == b"one"
    file.write(b"third")
    file.keep()
    assert file.tell() == len(b"onesecondthird")
    file.close()
    assert (tmp_path / "records").read_bytes() == b"onesecondthird"


def test_what_the_system_refuses_is_cut_off_and_ends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = WholeFile(tmp_path / "records")
    file.write(b"one")
    file.keep()
    file.write(b"second")
    breaks(monkeypatch, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with pytest.raises(OSError, match="space"):
        file.keep()
    assert file.closed
    assert (tmp_path / "records").read_bytes() == b"one"
