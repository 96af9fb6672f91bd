"""Bags that are cut, tampered with, or miss a file."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from foreign_bags import COUNT, FORMATS, Write, db3, robots_messages
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.recording import open_recording


@pytest.mark.parametrize("write", FORMATS)
def test_a_truncated_bag_is_refused_or_shorter(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path, robots_messages())
    file = path if path.is_file() else next(path.glob("*.db3"))
    content = file.read_bytes()
    for share in (0.02, 0.3, 0.6, 0.9, 0.999):
        file.write_bytes(content[: int(share * len(content))])
        assert len(read_or_refused(path)) <= COUNT


@pytest.fixture(scope="module", params=FORMATS)
def sound(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return request.param(tmp_path_factory.mktemp("sound"), robots_messages())


@pytest.mark.parametrize("write", FORMATS)
@pytest.mark.parametrize("topic", ["/odom", "/camera/depth/image_raw", "/tf_static"])
def test_only_the_undecodable_messages_are_skipped(
    tmp_path: Path, write: Write, topic: str
) -> None:
    messages = robots_messages()
    broken = [k for k, one in enumerate(messages) if one[0] == topic][:2]
    for k in broken:
        messages[k] = (*messages[k][:3], b"\0\1\0\0garbage")
    recording = open_recording(write(tmp_path, messages))
    lost = len(broken) if topic.endswith("image_raw") else 0
    assert len(list(recording)) == COUNT - lost
    ((name, reason),) = recording.skipped.items()
    assert name == f"messages on {topic}"
    assert (
        reason == f"{'1 is' if len(broken) == 1 else '2 are'} not of type {messages[broken[0]][1]}"
    )


@pytest.mark.parametrize("write", FORMATS)
def test_a_bag_of_undecodable_images_is_refused(tmp_path: Path, write: Write) -> None:
    messages = [
        (*one[:3], b"garbage") if one[0].endswith("image_raw") else one for one in robots_messages()
    ]
    with pytest.raises(
        InputError, match=r"messages on /camera/depth/image_raw: 6 are not of type sensor"
    ):
        list(open_recording(write(tmp_path, messages)))


HEAD = st.integers(0, 5000)
CHANGES = st.lists(
    st.tuples(st.one_of(HEAD, st.integers(0, 2**20)), st.binary(min_size=1, max_size=8)),
    min_size=1, max_size=6,
)  # fmt: skip


@given(changes=CHANGES, index=st.booleans())
@settings(max_examples=25)
def test_overwritten_bytes_raise_no_other_error_than_input_error(
    sound: Path, changes: list[tuple[int, bytes]], index: bool
) -> None:
    """A few bytes of its file, or of the index of its folder, are overwritten."""
    copy = sound.parent / f"tampered{sound.suffix}"
    if sound.is_dir():
        shutil.copytree(sound, copy, dirs_exist_ok=True)
    else:
        shutil.copy(sound, copy)
    file = copy
    if sound.is_dir():
        file = copy / "metadata.yaml" if index else next(copy.glob("*.db3"))
    content = bytearray(file.read_bytes())
    for place, values in changes:
        at = place % len(content)
        content[at : at + len(values)] = values
    file.write_bytes(content)
    read_or_refused(copy)


def read_or_refused(path: Path) -> list[Any]:
    try:
        return list(open_recording(path))
    except InputError:
        return []


def test_an_index_of_a_missing_file_is_refused(tmp_path: Path) -> None:
    folder = db3(tmp_path, robots_messages())
    next(folder.glob("*.db3")).unlink()
    with pytest.raises(InputError, match="can not be read"):
        open_recording(folder)
