"""Untrusted folders of images: paths that lead elsewhere, pipes, pictures that claim gigabytes."""

from __future__ import annotations

import io
import os
import resource
import struct
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from little_memory import little_memory
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from PIL import Image

from circumspect.errors import InputError
from circumspect.localization.image_folder import read_grey
from circumspect.localization.json_file import read_document
from circumspect.recording import open_recording
from circumspect.recording.frame_folder import read_colour, read_depth, read_pose
from circumspect.recording.open_recording import open_bag


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.png", "depth/../../secret.png"])
@pytest.mark.parametrize("lists", ["depth.txt", "rgb.txt"])
def test_lists_of_images_stay_in_their_folder(name, lists, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "depth.txt").write_text("1.0 depth.png\n")
    (folder / lists).write_text(f"1.0 {name}\n")
    with pytest.raises(InputError, match="outside the folder"):
        open_recording(folder)


def test_pipes_are_not_waited_for(tmp_path):
    for name in ("a.png", "a.mcap", "a.db3", "a.bag"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match="not a regular file"):
        read_depth(tmp_path / "a.png")
    assert read_colour(tmp_path / "a.png", (4, 4)) is None
    with pytest.raises(InputError, match="not a regular file"):
        read_grey(tmp_path / "a.png")
    os.mkfifo(tmp_path / "depth.txt")
    with pytest.raises(InputError, match="not a regular file"):
        open_recording(tmp_path)
    os.mkfifo(tmp_path / "pose.txt")
    with pytest.raises(InputError, match="not a regular file"):
        read_pose(tmp_path / "pose.txt")
    os.mkfifo(tmp_path / "space.json")
    with (
        pytest.raises(InputError, match="not a regular file"),
        read_document(tmp_path / "space.json"),
    ):
        pass
    for suffix in ("mcap", "db3", "bag"):
        with pytest.raises(InputError, match="not a regular file"):
            open_bag(tmp_path / f"a.{suffix}")


def png_bomb(width: int, height: int, bits: int) -> bytes:
    """A picture of one colour; only its first rows are there."""

    def part(name: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        )

    head = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    rows = zlib.compress(bytes(1 << 20))
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", rows) + part(b"IEND", b"")


@pytest.mark.parametrize("size", [(13_000, 13_000), (2**31 - 1, 1), (100_000, 100_000)])
def test_oversized_pictures_are_not_unpacked(size, tmp_path):
    path = tmp_path / "a.png"
    for bits, read in ((16, read_depth), (8, read_grey)):
        path.write_bytes(png_bomb(*size, bits))
        with little_memory(), pytest.raises(InputError, match=r"a\.png"):
            read(path)
    with little_memory():
        assert read_colour(path, (640, 480)) is None


def test_chunks_of_pictures_that_announce_gigabytes(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.arange(48, dtype=np.uint16).reshape(6, 8)).save(path)
    whole = path.read_bytes()
    at = whole.index(b"IDAT") - 4
    path.write_bytes(whole[:at] + b"\xff\xff\xff\xff" + whole[at + 4 :])
    limits = resource.getrlimit(resource.RLIMIT_AS)
    used = 4096 * int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 30), limits[1]))
    try:
        with suppress(InputError):
            assert read_depth(path).shape == (6, 8)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


def test_formats_that_other_programs_would_run_are_not_opened(tmp_path):
    buffer = io.BytesIO()
    Image.new("RGB", (4, 4)).save(buffer, "EPS")
    for name in ("frame-000000.color.jpg", "a.png"):
        (tmp_path / name).write_bytes(buffer.getvalue())
    assert read_colour(tmp_path / "frame-000000.color.jpg", (4, 4)) is None
    with pytest.raises(InputError, match="can not be read"):
        read_grey(tmp_path / "a.png")


def test_stamps_that_are_no_text_are_refused(tmp_path):
    from circumspect.localization.image_folder import ImageFolder

    (tmp_path / "north").mkdir()
    Image.new("L", (4, 4)).save(tmp_path / "north" / "1.png")
    (tmp_path / "north" / "stamps.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"stamps\.txt: can not be read"):
        ImageFolder(tmp_path)


def test_control_characters_in_names_are_escaped(tmp_path, capsys):
    from circumspect.cli.main import main

    path = tmp_path / "names.mcap"
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.NONE, use_chunking=False)
        writer.start()
        for name in ("/\x1b[2J\x1b]0;depth\x07", "/[/red]depth", "/[link=http://x]depth"):
            schema = writer.register_schema("sensor_msgs/msg/Image", "ros2msg", b"")
            writer.add_message(writer.register_channel(name, "cdr", schema), 1, b"", 1)
        writer.finish()
    assert main(["record", "info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "/[/red]depth" in out
    assert main(["replay", str(path), "--out", str(tmp_path / "run")]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "\x1b" not in err
