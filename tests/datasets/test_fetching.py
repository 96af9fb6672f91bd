"""Fetching from a server that breaks off, sends garbage, or is not there; on loopback only."""

import errno
import hashlib
import shutil
import threading
import time
import zipfile

import pytest
from archive_server import OFF, Server, archive

from circumspect.cli.main import main
from circumspect.datasets import fetching
from circumspect.datasets.fetching import fetch_modelnet10
from circumspect.datasets.resumed_download import CHUNK, ResumedDownload
from circumspect.errors import CircumspectError


@pytest.fixture
def server():
    with Server() as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def quick(tmp_path, attempts=3):
    return ResumedDownload(tmp_path / "ModelNet10.zip.part", attempts, pause=0.0)


def fetch(server, tmp_path, attempts=3, **options):
    return fetch_modelnet10(tmp_path, server.url, downloader=quick(tmp_path, attempts), **options)


def unpacked(folder):
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


def test_only_members_of_the_set_are_unpacked(server, tmp_path):
    folder = fetch(server, tmp_path)
    assert unpacked(folder) == ["bed/test/bed_0516.off", "chair/train/chair_0001.off"]
    assert (folder / "bed/test/bed_0516.off").read_bytes() == OFF * 4000
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10"]
    assert fetch(server, tmp_path) == folder
    assert len(server.asked) == 1


def test_an_empty_folder_is_filled_and_any_other_left(server, tmp_path):
    (tmp_path / "ModelNet10").mkdir()
    assert unpacked(fetch(server, tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10"]
    own = tmp_path / "other" / "ModelNet10"
    own.mkdir(parents=True)
    (own / "mine").write_text("kept")
    assert unpacked(fetch(server, tmp_path / "other")) == ["mine"]
    assert len(server.asked) == 1


def test_a_foreign_folder_of_that_name_is_reported_with_the_remedy(server, tmp_path, capsys):
    (tmp_path / "ModelNet10").mkdir()
    (tmp_path / "ModelNet10" / "mine").write_text("kept")
    assert main(["data", "fetch", "modelnet10", "--url", server.url, "--out", str(tmp_path)]) == 2
    reported = capsys.readouterr().err
    assert reported.startswith(f"circumspect: {tmp_path / 'ModelNet10'}: neither point packs")
    assert reported.endswith("remove it, or fetch to another folder by --out\n")


def test_a_server_that_breaks_off_is_asked_for_the_rest_alone(server, tmp_path):
    server.breaks_off_after = len(server.content) // 5 + 1
    assert unpacked(fetch(server, tmp_path))
    assert 5 <= len(server.asked) < 9
    assert server.asked[0] is None
    assert all(asked is not None for asked in server.asked[1:])


def test_an_interrupted_download_resumes(server, tmp_path):
    server.breaks_off_after = 100_000
    stopped = quick(tmp_path)
    stopped.progress = lambda done, total: (_ for _ in ()).throw(KeyboardInterrupt)
    with pytest.raises(KeyboardInterrupt):
        fetch_modelnet10(tmp_path, server.url, downloader=stopped)
    assert (tmp_path / "ModelNet10.zip.part").exists()
    server.breaks_off_after = None
    assert unpacked(fetch(server, tmp_path))
    assert server.asked[-1] == f"bytes={CHUNK}-"


def test_parts_of_two_versions_are_never_joined(server, tmp_path):
    server.breaks_off_after = 100_000
    with pytest.raises(CircumspectError):
        fetch(server, tmp_path, attempts=1)
    server.content, server.version, server.breaks_off_after = archive(), '"2"', None
    assert unpacked(fetch(server, tmp_path))


def test_a_server_without_progress_is_given_up(server, tmp_path):
    server.breaks_off_after = 0
    with pytest.raises(CircumspectError, match="the same command resumes"):
        fetch(server, tmp_path)
    assert len(server.asked) == 3


def test_a_server_that_refuses_to_resume_is_given_up(server, tmp_path):
    server.breaks_off_after, server.refuses_ranges = 100_000, True
    with pytest.raises(CircumspectError, match="can not be fetched") as caught:
        fetch(server, tmp_path)
    assert "\n" not in str(caught.value)
    assert [asked is None for asked in server.asked] == [True, False, True]


@pytest.mark.parametrize("off", [-1, 1, 1000])
def test_a_part_that_starts_elsewhere_is_not_joined(server, tmp_path, off):
    server.breaks_off_after, server.part_starts_off = 100_000, off
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch(server, tmp_path)
    server.breaks_off_after = None
    folder = fetch(server, tmp_path)
    assert (folder / "bed/test/bed_0516.off").read_bytes() == OFF * 4000


@pytest.mark.parametrize("called", ["", "bytes", "bytes x-y/z", "bytes */5"])
def test_a_part_that_does_not_say_where_it_starts_is_not_joined(server, tmp_path, called):
    server.breaks_off_after, server.part_is_called = 100_000, called
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch(server, tmp_path)


def test_a_partial_response_is_not_taken_for_the_whole(server, tmp_path):
    server.breaks_off_after = 100_000
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch(server, tmp_path, attempts=1)
    server.breaks_off_after, server.sends_at_most = None, 100_000
    assert unpacked(fetch(server, tmp_path))


def test_a_body_that_is_packed_on_its_way_is_fetched_as_a_whole(server, tmp_path):
    server.packs, server.breaks_off_after = True, 300
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch(server, tmp_path)
    server.breaks_off_after = None
    assert unpacked(fetch(server, tmp_path))
    assert set(server.asked) == {None}
    assert len(server.asked) == 3 + 1


@pytest.mark.parametrize("length", ["abc", "-1", "1e3", "9" * 5000])
def test_an_invalid_length_is_ignored(server, tmp_path, length):
    server.length = length
    assert unpacked(fetch(server, tmp_path))
    assert server.asked == [None]


def test_a_length_beyond_all_disks_is_one_line(server, tmp_path):
    server.length = "9" * 400
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch(server, tmp_path)


def test_only_a_checksum_that_was_asked_for_can_disagree(server, tmp_path, monkeypatch):
    def broken(*_):
        raise ValueError("something else")

    monkeypatch.setattr(ResumedDownload, "_continued", broken)
    with pytest.raises(ValueError, match="something else"):
        fetch(server, tmp_path)


def test_no_pause_after_the_last_attempt(server, tmp_path, monkeypatch):
    waits = []
    monkeypatch.setattr("circumspect.datasets.resumed_download.time.sleep", waits.append)
    server.breaks_off_after = 0
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch_modelnet10(
            tmp_path, server.url, downloader=ResumedDownload(tmp_path / "part", attempts=3)
        )
    assert waits == [1.0, 2.0]


def test_garbage_is_refused_and_not_kept(server, tmp_path):
    server.content = b"<html>we have moved</html>"
    with pytest.raises(CircumspectError, match="no sound archive"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []
    broken = bytearray(archive())
    broken[len(broken) // 4] ^= 0xFF
    server.content = bytes(broken)
    with pytest.raises(CircumspectError, match="no sound archive"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []
    broken = bytearray(archive(compression=zipfile.ZIP_DEFLATED))
    first = 30 + len("ModelNet10/chair/train/chair_0001.off")
    broken[first] = 0xFF  # No such kind of block.
    server.content = bytes(broken)
    with pytest.raises(CircumspectError, match="no sound archive"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []
    server.content = archive(names=())
    with pytest.raises(CircumspectError, match="holds no ModelNet10"):
        fetch(server, tmp_path)


def marked(first, second, value):
    """The archive with two bytes changed in the headers of every member."""
    content = bytearray(archive(compression=zipfile.ZIP_DEFLATED))
    for sign, place in ((b"PK\x03\x04", first), (b"PK\x01\x02", second)):
        at = content.find(sign)
        while at >= 0:
            content[at + place] = value
            at = content.find(sign, at + 1)
    return bytes(content)


def unreadable():
    """An archive whose member name is marked as UTF-8 and is not."""
    content = archive(names=("ModelNet10/ch\u00e4ir/train/chair_0001.off",))
    return content.replace("\u00e4".encode(), b"\xff\xff")


def spoilt(compression):
    content = bytearray(archive(compression=compression))
    content[90:130] = bytes(40)
    return bytes(content)


@pytest.mark.parametrize(
    ("content", "reported"),
    [
        (unreadable(), "decode"),
        (marked(6, 8, 1), "encrypted"),
        (marked(8, 10, 99), "compression"),
        (spoilt(zipfile.ZIP_LZMA), "Corrupt"),
        (spoilt(zipfile.ZIP_BZIP2), "Invalid data"),
    ],
    ids=["name", "encrypted", "unknown", "lzma", "bzip2"],
)
def test_archives_that_can_not_be_unpacked_are_not_kept(server, tmp_path, content, reported):
    server.content = content
    with pytest.raises(CircumspectError, match=rf"no sound archive \(.*{reported}"):
        fetch(server, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_broken_version_of_a_part_restarts_the_download(server, tmp_path):
    (tmp_path / "ModelNet10.zip.part").write_bytes(server.content[:100])
    (tmp_path / "ModelNet10.zip.part.version").write_bytes(b"\xff\xfe")
    assert unpacked(fetch(server, tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10"]


def test_a_disk_error_keeps_the_download(server, tmp_path, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(fetching.ZipFile, "extract", full)
        with pytest.raises(CircumspectError, match=r"the disk failed .*no space left.* stays"):
            fetch(server, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10.zip"]
    assert unpacked(fetch(server, tmp_path))
    assert len(server.asked) == 1


def full(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_complete_download_is_not_repeated(server, tmp_path, monkeypatch):
    """If it can not be moved to its place, for example to a full disk."""
    with monkeypatch.context() as patched:
        for name in ("move", "copyfileobj"):
            patched.setattr(f"circumspect.datasets.resumed_download.shutil.{name}", full)
        with pytest.raises(CircumspectError, match=r"can not be written \(no space left"):
            fetch(server, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10.zip.whole"]
    assert unpacked(fetch(server, tmp_path))
    assert server.asked == [None]
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10"]


def test_a_complete_download_needs_no_space_twice(server, tmp_path, monkeypatch):
    for name in ("copyfile", "copyfileobj", "copy2"):
        monkeypatch.setattr(shutil, name, full)
    target = tmp_path / "there"
    target.write_bytes(b"")
    quick(tmp_path)(server.url, str(target), None)
    assert target.read_bytes() == server.content
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_a_checksum_that_is_given_must_agree(server, tmp_path):
    right = hashlib.sha256(server.content).hexdigest()
    with pytest.raises(CircumspectError, match="checksum"):
        fetch(server, tmp_path, sha256="0" * 64)
    assert not (tmp_path / "ModelNet10").exists()
    assert fetch(server, tmp_path, sha256=right).is_dir()


def test_the_checksum_of_the_public_archive_is_known(server, tmp_path, monkeypatch):
    monkeypatch.setattr(fetching, "URL", server.url)
    with pytest.raises(CircumspectError, match=f"checksum {fetching.URL_SHA256}"):
        fetch(server, tmp_path)
    assert not (tmp_path / "ModelNet10").exists()
    monkeypatch.setattr(fetching, "URL_SHA256", hashlib.sha256(server.content).hexdigest())
    assert fetch(server, tmp_path).is_dir()


@pytest.mark.parametrize("given", ["zz", "", "0" * 63, "0" * 65, "0" * 64 + "\n", "g" * 64])
def test_an_invalid_checksum_is_refused_before_the_download(server, tmp_path, capsys, given):
    flags = ("--url", server.url, "--out", str(tmp_path), "--sha256", given)
    assert main(["data", "fetch", "modelnet10", *flags]) == 2
    reported = capsys.readouterr().err
    assert "64 hex digits" in reported
    assert reported.count("\n") == 1
    assert (server.asked, list(tmp_path.iterdir())) == ([], [])


def test_the_checksum_of_an_archive_that_is_there_already_must_agree(server, tmp_path):
    left = tmp_path / "ModelNet10.zip"
    left.write_bytes(server.content)
    with pytest.raises(CircumspectError, match=r"ModelNet10\.zip: .*checksum 0+; remove it"):
        fetch(server, tmp_path, sha256="0" * 64)
    assert left.read_bytes() == server.content
    right = hashlib.sha256(server.content).hexdigest().upper()
    assert fetch(server, tmp_path, sha256=right).is_dir()
    assert server.asked == []


def test_refusals_and_absence_are_one_line(server, tmp_path, capsys):
    server.status = 404
    with pytest.raises(CircumspectError, match="answers 404"):
        fetch(server, tmp_path)
    nowhere = "http://127.0.0.1:9/ModelNet10.zip"
    with pytest.raises(CircumspectError, match="can not be fetched"):
        fetch_modelnet10(tmp_path, nowhere, downloader=quick(tmp_path))
    assert main(["data", "fetch", "imagenet"]) == 2
    assert "known: modelnet10" in capsys.readouterr().err


@pytest.mark.parametrize("url", ["garbage", "ftp://host/ModelNet10.zip", "http://", "http://["])
def test_an_invalid_address_is_refused_at_once(url, tmp_path, capsys):
    start = time.monotonic()
    assert main(["data", "fetch", "modelnet10", "--url", url, "--out", str(tmp_path)]) == 2
    assert time.monotonic() - start < 5, "the usual downloader tries for half a minute"
    reported = capsys.readouterr().err
    assert reported.startswith(f"circumspect: {url}: is no address")
    assert reported.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_too_little_disk_space_is_reported_before_it_is_full(server, tmp_path, monkeypatch):
    class Usage:
        free = 1000

    monkeypatch.setattr("circumspect.datasets.resumed_download.shutil.disk_usage", lambda _: Usage)
    with pytest.raises(CircumspectError, match="room for"):
        fetch(server, tmp_path)
    monkeypatch.undo()
    monkeypatch.setattr(fetching.shutil, "disk_usage", lambda _: Usage)
    (tmp_path / "ModelNet10.zip").write_bytes(server.content)
    with pytest.raises(CircumspectError, match="to be unpacked"):
        fetch(server, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["ModelNet10.zip"]


def test_the_command_fetches_and_counts(server, tmp_path, capsys):
    assert main(["data", "fetch", "modelnet10", "--url", server.url, "--out", str(tmp_path)]) == 1
    text = capsys.readouterr().out
    assert "1 of 889" in text
    assert "not complete" in text
