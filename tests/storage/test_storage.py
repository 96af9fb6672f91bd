"""No partial file is left, however the writing ends."""

from __future__ import annotations

import errno
import json
import os
import resource
import signal
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from circumspect.errors import OutputError
from circumspect.storage import append_line, atomic_open, atomic_path, require_writable, write_json


@contextmanager
def largest_file(count: int) -> Iterator[None]:
    """The kernel refuses to let files grow further, as on a full disk or over quota."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (count, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A file that was written before."""
    path = tmp_path / "result.txt"
    path.write_text("old")
    return path


def assert_untouched(path: Path) -> None:
    assert path.read_text() == "old"
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def one_line(error: pytest.ExceptionInfo[OutputError], path: Path) -> str:
    message = str(error.value)
    assert str(path) in message
    assert "\n" not in message
    return message


def test_writes_and_replaces(old: Path):
    with atomic_open(old) as stream:
        stream.write("nëw")
        assert old.read_text() == "old"
    assert old.read_text(encoding="utf-8") == "nëw"
    assert [entry.name for entry in old.parent.iterdir()] == [old.name]


def test_makes_folders_and_keeps_the_suffix(tmp_path: Path):
    with atomic_path(tmp_path / "a" / "b" / "grid.npz") as aside:
        assert aside.suffix == ".npz"
        aside.write_bytes(b"1")
    assert (tmp_path / "a" / "b" / "grid.npz").read_bytes() == b"1"


def test_permissions_are_those_of_any_new_file(tmp_path: Path):
    mask = os.umask(0o027)
    try:
        with atomic_open(tmp_path / "new") as stream:
            stream.write("1")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


def test_long_and_odd_names(tmp_path: Path):
    for name in ("x" * 250, "ü" * 120 + ".json", ".hidden", "two\nlines", "no.suffix.here."):
        with atomic_open(tmp_path / name) as stream:
            stream.write("1")
        assert (tmp_path / name).read_text() == "1"
    assert len(list(tmp_path.iterdir())) == 5


@pytest.mark.parametrize("fault", [ValueError, KeyboardInterrupt, SystemExit, MemoryError])
def test_a_crash_in_the_middle_leaves_the_old_file(old: Path, fault: type[BaseException]):
    with pytest.raises(fault), atomic_open(old) as stream:  # noqa: PT012
        stream.write("half")
        stream.flush()
        raise fault
    assert_untouched(old)


def test_disk_full_while_writing(old: Path):
    with pytest.raises(OutputError) as error, atomic_open(old) as stream:  # noqa: PT012
        stream.write("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert "no space left" in one_line(error, old)
    assert_untouched(old)


def test_disk_really_full(old: Path):
    with largest_file(4096), pytest.raises(OutputError) as error, atomic_open(old, "wb") as stream:
        stream.write(bytes(1_000_000))
    assert "file too large" in one_line(error, old)
    assert_untouched(old)


def test_disk_full_when_the_rest_is_flushed(old: Path):
    with largest_file(0), pytest.raises(OutputError), atomic_open(old) as stream:
        stream.write("buffered, written when the file is closed")
    assert_untouched(old)


def test_folder_in_place_of_the_file(tmp_path: Path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(OutputError, match="is a folder") as error, atomic_open(tmp_path / "taken"):
        pytest.fail("the block must not run")
    one_line(error, tmp_path / "taken")
    assert not list((tmp_path / "taken").iterdir())


def test_no_folder_can_be_made_below_a_file(old: Path):
    with pytest.raises(OutputError, match="not a directory"), atomic_open(old / "below" / "x"):
        pytest.fail("the block must not run")
    assert_untouched(old)


def test_no_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object) -> int:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(os, "open", refuse)
    x = tmp_path / "x"
    with pytest.raises(OutputError, match="permission denied") as error, atomic_open(x):
        pytest.fail("the block must not run")
    one_line(error, tmp_path / "x")


def test_a_folder_without_write_permission():
    message = r"^/proc/nowhere/x: can not be written"
    with pytest.raises(OutputError, match=message), atomic_open("/proc/nowhere/x"):
        pytest.fail("the block must not run")


def test_devices_are_not_replaced():
    with pytest.raises(OutputError, match="not a regular file"), atomic_open("/dev/null"):
        pytest.fail("the block must not run")
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_a_link_is_followed(old: Path):
    link = old.with_name("link")
    link.symlink_to(old)
    with atomic_open(link) as stream:
        stream.write("new")
    assert link.is_symlink()
    assert old.read_text() == "new"


def test_a_link_in_a_circle(tmp_path: Path):
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(OutputError, match="symbolic links"), atomic_open(tmp_path / "a"):
        pytest.fail("the block must not run")


def test_errors_of_other_files_keep_their_name(old: Path):
    with pytest.raises(FileNotFoundError, match="missing"), atomic_open(old):
        (old.parent / "missing").read_bytes()
    assert_untouched(old)


def test_a_closed_pipe_is_not_a_full_disk(old: Path):
    with pytest.raises(BrokenPipeError), atomic_open(old):
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))
    assert_untouched(old)


def test_json_holds_plain_values(tmp_path: Path):
    document = {
        "float": np.float32(0.5),
        "int": np.int64(3),
        "array": np.arange(3),
        "nan": [float("nan"), np.float64("inf")],
        "path": Path("a/b"),
        "flag": np.bool_(True),
        "none": None,
        "word": "größe",
        4: (1, 2),
    }
    write_json(tmp_path / "x.json", document)
    text = (tmp_path / "x.json").read_text(encoding="utf-8")
    assert "größe" in text
    assert json.loads(text, parse_constant=pytest.fail) == {
        "float": 0.5,
        "int": 3,
        "array": [0, 1, 2],
        "nan": [None, None],
        "path": "a/b",
        "flag": True,
        "none": None,
        "word": "größe",
        "4": [1, 2],
    }


def test_values_that_json_can_not_hold_leave_no_file(tmp_path: Path):
    with pytest.raises(TypeError):
        write_json(tmp_path / "x.json", {"x": object()})
    assert not list(tmp_path.iterdir())


def test_a_folder_is_tried_and_left_as_it_was(tmp_path: Path):
    require_writable(tmp_path / "new" / "run")
    assert list((tmp_path / "new" / "run").iterdir()) == []
    (tmp_path / "file").write_text("kept")
    with pytest.raises(OutputError, match="can not be written"):
        require_writable(tmp_path / "file" / "run")
    assert (tmp_path / "file").read_text() == "kept"


def test_lines_are_added_whole_or_not_at_all(tmp_path: Path):
    path = tmp_path / "log.jsonl"
    append_line(path, "one")
    path.write_bytes(path.read_bytes() + b"tw")
    append_line(path, "zwei €", durable=True)
    assert path.read_text(encoding="utf-8") == "one\nzwei €\n"
    path.write_text("nothing whole")
    append_line(path, "one")
    assert path.read_text() == "one\n"
    with pytest.raises(OutputError, match="can not be written"):
        append_line(tmp_path / "nowhere" / "log.jsonl", "one")


def test_a_line_that_does_not_fit_leaves_the_file_as_it_was(tmp_path: Path):
    path = tmp_path / "log.jsonl"
    append_line(path, "kept")
    with largest_file(100), pytest.raises(OutputError, match=r"log\.jsonl: can not be written"):
        append_line(path, "x" * 200)
    assert path.read_text() == "kept\n"
