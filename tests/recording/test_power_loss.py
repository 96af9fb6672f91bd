"""What a loss of power leaves: writes that reach the disk in any order, torn, or not at all."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from bag_world import frame
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.datasets.gathered_set import MANIFEST, GatheredScan, read_manifest
from circumspect.errors import InputError
from circumspect.recording import RunRecorder, open_recording
from circumspect.runs import RunFolder
from circumspect.storage import append_line, atomic_open, write_json

PAGE = 4096


class Disk:
    """Records in which order contents and names are made durable."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.durable: dict[int, bytes] = {}
        """Contents of files by number, as they were synced last."""
        self.renamed: list[Path] = []
        """Files whose new name is not durable yet."""
        real_sync, real_replace = os.fsync, Path.replace

        def sync(place: int) -> None:
            real_sync(place)
            path = Path(f"/proc/self/fd/{place}").readlink()
            if path.is_dir():
                self.renamed = [file for file in self.renamed if file.parent != path]
            else:
                self.durable[os.fstat(place).st_ino] = path.read_bytes()

        def replace(source: Path, target: Path) -> Path:
            # A name may reach the disk at once; so what it names has to be there before.
            assert self.durable.get(source.stat().st_ino) == source.read_bytes(), source
            self.renamed.append(Path(target))
            return real_replace(source, target)

        monkeypatch.setattr(os, "fsync", sync)
        monkeypatch.setattr(Path, "replace", replace)


def test_contents_are_durable_before_names_and_names_before_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = Disk(monkeypatch)
    for text in ("old", "new"):
        with atomic_open(tmp_path / "a.txt") as stream:
            stream.write(text)
        assert disk.renamed == []
    write_json(tmp_path / "a.json", {"a": 1})
    RunFolder(tmp_path / "run", {"object": "chair"})
    assert disk.renamed == []
    assert len(disk.durable) >= 4


def test_a_finished_recording_is_durable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    disk, path = Disk(monkeypatch), tmp_path / "run.mcap"
    recorder = RunRecorder(path, {})
    recorder.frame(frame(0))
    recorder.close()
    assert disk.durable[path.stat().st_ino] == path.read_bytes()


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("power") / "run.mcap"
    recorder = RunRecorder(path, {})
    for number in range(20):
        recorder.frame(frame(number))
    recorder.close()
    return path.read_bytes()


@given(data=st.data())
@settings(max_examples=30)
def test_a_recording_without_some_pages_gives_the_frames_of_the_others(
    recording: bytes, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """The file has its length, but pages of its second half were not written: they are zero."""
    pages = range(len(recording) // PAGE // 2, len(recording) // PAGE + 1)
    lost = data.draw(st.sets(st.sampled_from(pages), max_size=3))
    end = data.draw(st.integers(pages[0] * PAGE, len(recording)))
    content = bytearray(recording[:end])
    for page in lost:
        part = content[page * PAGE : (page + 1) * PAGE]
        content[page * PAGE : page * PAGE + len(part)] = bytes(len(part))
    path = tmp_path_factory.mktemp("torn") / "run.mcap"
    path.write_bytes(content)
    assert len(list(open_recording(path))) >= 7


@given(data=st.data())
@settings(max_examples=30)
def test_a_manifest_loses_its_last_line_at_most(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Each line is durable before the next one is begun."""
    folder = tmp_path_factory.mktemp("set")
    scans = [GatheredScan(f"a@{n:03}", "a", "chair", "train", 1.0 * n) for n in range(5)]
    for scan in scans:
        append_line(folder / MANIFEST, scan.line().rstrip("\n"))
    last = scans[-1].line().encode()
    written = data.draw(st.integers(0, len(last)))
    zeros = data.draw(st.integers(0, len(last) - written))
    kept = (folder / MANIFEST).read_bytes()[: -len(last)]
    (folder / MANIFEST).write_bytes(kept + last[:written] + bytes(zeros))
    found = read_manifest(folder)
    assert found[:4] == scans[:4]
    append_line(folder / MANIFEST, scans[-1].line().rstrip("\n"))
    assert read_manifest(folder) == scans


def test_a_page_of_zeros_within_a_manifest_is_a_known_fault(tmp_path: Path) -> None:
    line = json.dumps({"scan": "a"})
    (tmp_path / MANIFEST).write_bytes(bytes(PAGE) + line.encode() + b"\n")
    with pytest.raises(InputError, match="line 1: is no scan"):
        read_manifest(tmp_path)
