"""Sets grow in folders and in object stores alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from here_pool import HerePool

from circumspect.cli.commands import gather as gather_command
from circumspect.cli.commands.convert import Conversion, convert_set
from circumspect.cli.main import main
from circumspect.datasets.gathered_set import GatheredScan, read_gathered, read_manifest
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.errors import InputError, OutputError
from circumspect.gathering import GatherSettings, LocalPool, objects_for
from circumspect.gathering.gather import gather
from circumspect.gathering.set_place import SetBucket, SetFolder, place_of

fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed")
HOW = Conversion("planes", 2, 64, 0, 1)
SETTINGS = GatherSettings(("bed", "chair"), 3, 1, (0.0,), (0.0,), frame_interval=2.0, frames=3)
URL = "memory://gathered/set"


@pytest.fixture(autouse=True)
def empty_store() -> Iterator[None]:
    fsspec.filesystem("memory").store.clear()
    yield
    fsspec.filesystem("memory").store.clear()


@pytest.fixture(scope="module")
def gathered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("set") / "set"
    gather(SetFolder(folder), SETTINGS, objects_for(SETTINGS), HerePool())
    return folder


def in_store(pool: Any = None) -> list[GatheredScan]:
    return gather(place_of(URL), SETTINGS, objects_for(SETTINGS), pool or HerePool())


def without_time(scan: GatheredScan) -> GatheredScan:
    return replace(scan, quality={**scan.quality, "processor_s": None})


def test_an_object_store_holds_the_same_set_as_a_folder(gathered: Path) -> None:
    scans = in_store()
    here = sorted(read_manifest(gathered), key=lambda scan: scan.scan)
    assert list(map(without_time, scans)) == list(map(without_time, here))
    with place_of(URL).local(scans) as folder:
        copy, whole = (read_gathered(one, "train") for one in (folder, gathered))
    order = np.argsort(whole.names)
    np.testing.assert_array_equal(copy.points_xyz, whole.points_xyz[order])
    files = fsspec.filesystem("memory").glob(f"{URL}/**/*.*")
    assert len(files) == 8 * 5 + 2
    assert SetBucket(URL).settings()["frame_interval"] == 2.0


def test_an_interrupted_set_resumes_where_nothing_can_be_appended() -> None:
    class Cut(HerePool):
        def outcomes(self, jobs: Any, work: Any) -> Iterator[tuple[Any, Any]]:
            for number, job in enumerate(jobs):
                yield job, OSError("lost") if number == 2 else work(job)

    with pytest.raises(OutputError, match=f"{URL}: 1 scans failed, the first: .* the same command"):
        in_store(Cut())
    pool = HerePool()
    assert len(in_store(pool)) == 8
    assert len(pool.done) == 1
    assert len({scan.scan for scan in place_of(URL).scans()}) == 8


def test_foreign_objects_in_a_store_are_kept() -> None:
    fsspec.filesystem("memory").pipe_file(f"{URL}/notes.txt", b"mine")
    with pytest.raises(InputError, match=r"notes\.txt: is of something else; give a new URL"):
        in_store()
    fsspec.filesystem("memory").store.clear()
    for content in (b"{", b"[]"):
        fsspec.filesystem("memory").pipe_file(f"{URL}/settings.json", content)
        with pytest.raises(InputError, match=r"settings\.json: is of no gathered set"):
            in_store()
    SetBucket(URL).write_settings({})
    fsspec.filesystem("memory").pipe_file(f"{URL}/scans/a.json", b"{}")
    with pytest.raises(InputError, match=r"scans/a\.json: is no scan"):
        in_store()


def test_a_set_in_a_store_is_converted(gathered: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no gathered set"):
        convert_set(URL, str(tmp_path / "none"), HOW)
    in_store()
    counts = convert_set(URL, str(tmp_path / "a"), HOW)
    assert counts == convert_set(str(gathered), str(tmp_path / "b"), HOW)
    with ShardedSet.read(tmp_path / "a", "test") as shards:
        rows = next(shards.in_order())
    assert rows.starts_deg.tolist() == [0.0, 0.0]


def test_the_command_gathers_into_a_store(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    # Other processes have other memory.
    monkeypatch.setattr(
        LocalPool, "outcomes", lambda _, jobs, work: HerePool().outcomes(jobs, work)
    )
    flags = ["--classes", "chair", "--train-objects", "1", "--test-objects", "0", "--frames", "3"]
    assert main(["gather", "--out", URL, *flags]) == 0
    assert f"1 scan is in {URL}; look at {URL}/{gather_command.SHEET}" in capsys.readouterr().out
    assert fsspec.filesystem("memory").cat_file(f"{URL}/{gather_command.SHEET}")[1:4] == b"PNG"
    assert main(["gather", "--out", URL, "--from", "x.mcap", "--label", "chair"]) == 2
    assert "recordings are added to sets in folders" in capsys.readouterr().err
    assert main(["gather", "--out", "nonsense://x", *flags]) == 2
    assert "nonsense" in capsys.readouterr().err
