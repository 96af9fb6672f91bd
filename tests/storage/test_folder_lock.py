"""Two runs never share a folder; a killed run leaves neither a lock nor partial files."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from circumspect.errors import OutputError
from circumspect.folder_lock import NAME, lock_folder
from circumspect.runs import RunFolder

HOLDER = """
import sys
from pathlib import Path
from circumspect.folder_lock import lock_folder
from circumspect.storage import atomic_open
lock = lock_folder(Path(sys.argv[1]))
with atomic_open(Path(sys.argv[1]) / "half.npz", "wb") as stream:
    stream.write(b"half")
    stream.flush()
    print("locked", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path: Path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path / "run")],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdin is not None
    assert process.stdout.readline() == "locked\n"
    yield process
    process.kill()
    process.wait()
    process.stdin.close()
    process.stdout.close()


def test_a_second_run_is_rejected_until_the_first_ends(tmp_path: Path, holder) -> None:
    folder = tmp_path / "run"
    with pytest.raises(OutputError, match="another run writes to it") as error:
        RunFolder(folder, {})
    assert str(error.value).startswith(f"{folder}: ")
    assert not (folder / "config.json").exists(), "nothing of the second run"
    holder.communicate("")
    RunFolder(folder, {})
    assert (folder / "config.json").exists()


def test_a_killed_run_neither_blocks_nor_leaves_temporary_files(tmp_path: Path, holder) -> None:
    folder = tmp_path / "run"
    mine = folder / ".notes-of-mine.npz"
    mine.touch()
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    left = {file.name for file in folder.iterdir()}
    assert len(left) == 3, "the lock, half a grid, and the user's own file"
    lock = lock_folder(folder)
    assert {file.name for file in folder.iterdir()} == {NAME, mine.name}
    del lock
    gc.collect()
    assert [file.name for file in folder.iterdir()] == [mine.name]


def test_within_a_process_a_folder_can_be_taken_again(tmp_path: Path) -> None:
    first = lock_folder(tmp_path)
    second = lock_folder(tmp_path / ".." / tmp_path.name)
    assert first is second
    del first
    assert (tmp_path / NAME).exists()
    del second
    gc.collect()
    assert not (tmp_path / NAME).exists()


def test_a_folder_that_can_not_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file/run: can not be written"):
        lock_folder(tmp_path / "file" / "run")
