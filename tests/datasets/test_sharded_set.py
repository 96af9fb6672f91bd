"""Sets in shards: every grid once an epoch, from any batch on, and damage is named."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.datasets import shard_file, sharded_set
from circumspect.datasets.set_store import SetStore
from circumspect.datasets.shard_file import Rows, ShardHead, write_shard
from circumspect.datasets.sharded_set import ShardedSet
from circumspect.errors import InputError, MissingExtraError, OutputError

pytest.importorskip("pyarrow", reason="pyarrow is not installed")
HEAD = ShardHead(
    {"kind": "cylindrical"}, (1, 4, 8, 3), ("chair", "sofa"), {"seed": 0}, "train", 0, 1, "0.1.0"
)
NUMBERS = itertools.count()


def rows(count: int, first: int = 0) -> Rows:
    rng = np.random.default_rng(first)
    names = np.array([f"object-{first + number}" for number in range(count)], np.str_)
    starts = np.where(np.arange(count) % 3, np.nan, 45.0)
    packed = rng.integers(0, 256, (count, 12), dtype=np.uint8)
    return Rows(packed, rng.integers(0, 2, count), names, starts)


def written(url: str, sizes: list[int]) -> list[Rows]:
    firsts = np.cumsum([0, *sizes])
    parts = [rows(size, int(first)) for size, first in zip(sizes, firsts[:-1], strict=True)]
    for number, part in enumerate(parts):
        write_shard(SetStore(url), replace(HEAD, number=number, count=len(sizes)), part)
    return parts


@pytest.fixture
def groups_of_5(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shard_file, "GROUP", 5)
    monkeypatch.setattr(sharded_set, "BUFFER", 3)


@pytest.fixture
def memory() -> str:
    """An object store."""
    return f"memory://sets/{next(NUMBERS)}"


@pytest.mark.parametrize("store", ["folder", "memory"])
def test_shards_round_trip(store: str, tmp_path: Path, memory: str) -> None:
    url = str(tmp_path / "set") if store == "folder" else memory
    parts = written(url, [7, 3])
    with ShardedSet.read(url, "train") as found:
        assert len(found) == 10
        assert found.classes == ("chair", "sofa")
        assert found.head.input_spec == {"kind": "cylindrical"}
        read = Rows.joined(list(found.in_order()))
        whole = Rows.joined(parts)
        for name in ("packed", "labels", "objects", "starts_deg"):
            np.testing.assert_array_equal(getattr(read, name), getattr(whole, name))
        grids = found.unpacked(read)
        assert grids.shape == (10, 1, 4, 8, 3)
        np.testing.assert_array_equal(np.packbits(grids.reshape(10, -1), axis=1), whole.packed)
        assert found.counts() == {
            "chair": int((whole.labels == 0).sum()), "sofa": int((whole.labels == 1).sum())
        }  # fmt: skip


def test_head_of_format_2_is_converted() -> None:
    grids = {"kind": "cylindrical", "dithered": False}
    head = replace(HEAD, input_spec=grids, counts=(0, 0))
    stored = json.loads(head.to_json())
    del stored["input_spec"]
    stored |= {"format": 2, "recipe": {"kind": "cylindrical", "staggered": False}}
    read = ShardHead.from_json(json.dumps(stored).encode())
    assert read == head
    # The digest that networks of format 2 were trained on.
    content = [stored["recipe"], {"seed": 0}, "train", 1]
    expected = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    assert read.digest == expected


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.integers(1, 23), min_size=1, max_size=5), st.integers(1, 4), st.integers(1, 3),
    st.integers(0, 9),
)  # fmt: skip
def test_an_epoch_shows_no_grid_twice_and_leaves_little_out(
    sizes: list[int], share: int, world: int, seed: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shard_file, "GROUP", 5)
        patch.setattr(sharded_set, "BUFFER", 3)
        url, batch = f"memory://sets/{next(NUMBERS)}", share * world
        written(url, sizes)
        with ShardedSet.read(url, "train") as found:
            streams = [list(found.batches(batch, seed, 0, rank, world)) for rank in range(world)]
            steps = found.steps(batch, world)
    assert [len(stream) for stream in streams] == [steps] * world
    assert all(len(part) == share for stream in streams for part in stream)
    shown = Counter(name for stream in streams for part in stream for name in part.objects.tolist())
    assert set(shown.values()) <= {1}
    if world == 1:
        assert len(shown) == sum(sizes) // share * share


def test_an_epoch_resumes_at_any_batch(groups_of_5: None, memory: str) -> None:
    written(memory, [23, 12, 9])
    with ShardedSet.read(memory, "train") as found:
        whole = list(found.batches(4, 3))
        for first in range(len(whole) + 1):
            later = list(found.batches(4, 3, first))
            assert [part.objects.tolist() for part in later] == [
                part.objects.tolist() for part in whole[first:]
            ]
        other = list(found.batches(4, 4))
        assert [part.objects.tolist() for part in other] != [p.objects.tolist() for p in whole]


def test_shards_before_the_first_batch_are_not_read(
    groups_of_5: None, memory: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(memory, [50])
    with ShardedSet.read(memory, "train") as found:
        read: list[int] = []
        original = shard_file.ShardFile.rows
        monkeypatch.setattr(
            shard_file.ShardFile, "rows", lambda f, n: read.append(n) or original(f, n)
        )
        next(found.batches(5, 0, 9))
        assert len(read) <= 3, "those of one buffer"


def test_a_missing_shard_is_named(tmp_path: Path) -> None:
    written(str(tmp_path), [5, 5, 5])
    (tmp_path / "train" / "00001-of-00003.parquet").unlink()
    with pytest.raises(InputError, match=r"00001-of-00003\.parquet: is missing"):
        ShardedSet.read(tmp_path, "train")
    with pytest.raises(InputError, match="holds no shard of the test split"):
        ShardedSet.read(tmp_path, "test")


@pytest.mark.parametrize("kept", [0, 1, 200, -9])
def test_a_truncated_shard_is_named(kept: int, tmp_path: Path) -> None:
    written(str(tmp_path), [30, 30])
    file = tmp_path / "train" / "00001-of-00002.parquet"
    file.write_bytes(file.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"00001-of-00002\.parquet: is no whole shard"):
        ShardedSet.read(tmp_path, "train")


def test_no_flipped_bit_gives_a_wrong_grid(tmp_path: Path) -> None:
    (part,) = written(str(tmp_path), [40])
    file = tmp_path / "train" / "00000-of-00001.parquet"
    content = file.read_bytes()
    for place in np.linspace(4, len(content) - 1, 60).astype(int).tolist():
        broken = bytearray(content)
        broken[place] ^= 4
        file.write_bytes(broken)
        message, read = "", part
        try:
            with ShardedSet.read(tmp_path, "train") as found:
                read = Rows.joined(list(found.in_order()))
        except InputError as error:
            message = str(error)
        assert not message or "00000-of-00001.parquet" in message
        assert len(message.splitlines()) <= 1
        np.testing.assert_array_equal(read.packed, part.packed)
        np.testing.assert_array_equal(read.labels, part.labels)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"classes": ("chair", "table")}, "differs in classes from"),
        ({"input_spec": {"kind": "rectangular"}}, "differs in input_spec from"),
        ({"source": {"seed": 1}}, "differs in source from"),
    ],
)
def test_shards_that_do_not_fit_are_named(changed: dict, message: str, tmp_path: Path) -> None:
    written(str(tmp_path), [5, 5])
    write_shard(SetStore(tmp_path), replace(HEAD, number=1, count=2, **changed), rows(5))
    with pytest.raises(InputError, match=rf"00001-of-00002\.parquet: {message}"):
        ShardedSet.read(tmp_path, "train")


def test_shards_of_two_sets_are_reported(tmp_path: Path) -> None:
    written(str(tmp_path), [5, 5])
    write_shard(SetStore(tmp_path), replace(HEAD, number=2, count=3), rows(5))
    with pytest.raises(InputError, match="holds shards of several sets"):
        ShardedSet.read(tmp_path, "train")


def test_another_parquet_file_is_no_shard(tmp_path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    (tmp_path / "train").mkdir()
    parquet.write_table(pa.table({"a": [1]}), tmp_path / "train" / "00000-of-00001.parquet")
    with pytest.raises(InputError, match="it has no circumspect metadata"):
        ShardedSet.read(tmp_path, "train")


def test_rows_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    store = SetStore(tmp_path)
    with pytest.raises(InputError, match="are not 12 bytes each"):
        write_shard(store, HEAD, replace(rows(3), packed=np.zeros((3, 5), np.uint8)))
    with pytest.raises(InputError, match="outside the 2 classes"):
        write_shard(store, HEAD, replace(rows(3), labels=np.array([0, 1, 2])))
    assert not list(tmp_path.iterdir())


def test_an_unwritable_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "train").write_text("a file")
    with pytest.raises(OutputError):
        write_shard(SetStore(tmp_path), HEAD, rows(3))


def test_an_unknown_kind_of_url_is_reported() -> None:
    with pytest.raises((InputError, MissingExtraError), match="nowhere://set"):
        SetStore("nowhere://set")
