from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from circumspect.recording import mcap_writer
from circumspect.recording.mcap_writer import AtomicAppendFile


def breaks(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """The next write gets half of its bytes onto the disk."""
    write = os.write

    def half(file: int, data: memoryview) -> int:
        monkeypatch.setattr(mcap_writer.os, "write", write)
        write(file, data[: len(data) // 2])
        raise error

    monkeypatch.setattr(mcap_writer.os, "write", half)


@pytest.fixture
def begun(tmp_path: Path) -> AtomicAppendFile:
    """A file that holds one record, and a second one that is to be kept."""
    file = AtomicAppendFile(tmp_path / "records")
    file.write(b"one")
    file.commit()
    file.write(b"second")
    return file


def test_an_interrupted_record_is_written_once_by_the_next_commit(
    begun: AtomicAppendFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(monkeypatch, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        begun.commit()
    assert (tmp_path / "records").read_bytes() == b"one"
    begun.write(b"third")
    begun.commit()
    assert begun.tell() == len(b"onesecondthird")
    begun.close()
    assert (tmp_path / "records").read_bytes() == b"onesecondthird"


def test_a_failed_write_is_cut_off_and_closes_the_file(
    begun: AtomicAppendFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    breaks(monkeypatch, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    with pytest.raises(OSError, match="space"):
        begun.commit()
    assert begun.closed
    assert (tmp_path / "records").read_bytes() == b"one"
