"""Whatever bytes a file holds: a valid cloud comes out, or one line that says what is wrong."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shape_files
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.errors import InputError
from circumspect.geometry import PointCloud, TriangleMesh, read_cloud, read_mesh

# Far above what any of these small files takes, far below what a trusted false count would take.
TIME_LIMIT = 5.0
WORDS = [
    b"nan",
    b"inf",
    b"-1",
    b"1e999",
    b"99999999999999999999",
    b"0",
    b" ",
    b"\n",
    b"\x00",
    b"\xff",
]

positions = st.floats(0, 1, exclude_max=True)
mutations = st.one_of(
    st.tuples(st.just("flip"), positions, st.integers(1, 255)),
    st.tuples(st.just("cut off"), positions, st.none()),
    st.tuples(
        st.just("insert"), positions, st.one_of(st.sampled_from(WORDS), st.binary(max_size=9))
    ),
    st.tuples(
        st.just("overwrite"), positions, st.one_of(st.sampled_from(WORDS), st.binary(max_size=9))
    ),
    st.tuples(st.just("repeat"), positions, st.integers(1, 300)),
    st.tuples(st.just("remove"), positions, st.integers(1, 300)),
    st.tuples(st.just("digit"), positions, st.sampled_from(list(b"0123456789-+.eE"))),
)


def mutated(data: bytes, mutation: tuple[str, float, object]) -> bytes:
    kind, position, what = mutation
    at = int(position * len(data))
    head, tail = data[:at], data[at:]
    if kind == "flip":
        return head + bytes(byte ^ what for byte in tail[:1]) + tail[1:]
    if kind == "cut off":
        return head
    if kind == "insert":
        return head + what + tail
    if kind == "overwrite":
        return head + what + tail[len(what) :]
    if kind == "repeat":
        return head + tail[:what] + tail
    if kind == "remove":
        return head + tail[what:]
    # Another digit in the first number from here on: wrong counts, indices and coordinates.
    digits = [i for i, byte in enumerate(tail) if byte in b"0123456789"]
    return head + tail[: digits[0]] + bytes([what]) + tail[digits[0] + 1 :] if digits else data


def check(read: Callable[[], PointCloud | TriangleMesh], path: Path) -> None:
    """A shape, or one line about this file."""
    message = ""
    try:
        shape = read()
    except InputError as error:
        message = str(error)
    if message:
        assert message.startswith(f"{path}: ")
        assert message.isprintable()
        assert len(message) < 1000
    else:
        points = shape.points_xyz if isinstance(shape, PointCloud) else shape.vertices_xyz
        assert np.isfinite(points).all()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mutated")


@pytest.mark.parametrize("name", [*shape_files.MESHES, *shape_files.CLOUDS])
@given(changes=st.lists(mutations, min_size=1, max_size=4))
@settings(max_examples=60)
def test_a_cloud_or_one_line(name: str, changes: list[tuple], folder: Path):
    data = (shape_files.MESHES | shape_files.CLOUDS)[name]()
    for change in changes:
        data = mutated(data, change)
    path = folder / name
    path.write_bytes(data)
    start = time.process_time()
    check(lambda: read_cloud(path, samples=64), path)
    check(lambda: read_mesh(path), path)
    assert time.process_time() - start < TIME_LIMIT


@pytest.mark.parametrize(
    "suffix", sorted({Path(n).suffix for n in [*shape_files.MESHES, *shape_files.CLOUDS]})
)
@given(data=st.binary(max_size=200))
@settings(max_examples=50)
def test_noise(suffix: str, data: bytes, folder: Path):
    path = folder / f"noise{suffix}"
    path.write_bytes(data)
    check(lambda: read_cloud(path, samples=8), path)
