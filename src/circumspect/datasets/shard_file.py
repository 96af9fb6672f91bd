"""One shard of a set of grids: a Parquet file that describes itself.

| column | what it holds |
|---|---|
| grid | the views of an object as packed bits |
| label | index into the classes |
| object | the object's name; variants and scans of one object share it |
| start_deg | azimuth from which it was scanned [degrees]; null where it was not |

The metadata "circumspect" of the schema hold a `ShardHead` as JSON.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.set_store import SetStore
from circumspect.errors import InputError, MissingExtraError

FORMAT = 2
KEY = b"circumspect"
GROUP = 512
"""Grids in a row group, the least that is read at a time."""


@dataclass(frozen=True)
class ShardHead:
    """What all grids of a shard have in common; JSON types.

    Attributes:
        recipe: What made the grids, see `recipe_from_dict`.
        shape: Views of an object that lie together, and cells along each axis of a grid.
        classes: What labels count.
        source: Which objects they are of, and how variants were drawn.
        split: train, validation or test.
        number: Of the shard, from 0.
        count: Of shards in the split.
        version: Of circumspect.
        counts: Grids of each class; `write_shard` counts them.
    """

    recipe: dict[str, Any]
    shape: tuple[int, ...]
    classes: tuple[str, ...]
    source: dict[str, Any]
    split: str
    number: int
    count: int
    version: str
    counts: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Of the shard's file inside the set."""
        return f"{self.split}/{self.number:05}-of-{self.count:05}.parquet"

    @property
    def grid_bytes(self) -> int:
        """Of one packed grid."""
        return -(-int(np.prod(self.shape)) // 8)

    @property
    def digest(self) -> str:
        """A hash of what the split was made of; the same for all of its shards."""
        content = json.dumps([self.recipe, self.source, self.split, self.count], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    def to_json(self) -> str:
        """As the metadata hold it."""
        return json.dumps({"format": FORMAT, **asdict(self)})

    @classmethod
    def from_json(cls, text: bytes | None) -> ShardHead:
        """Read what `to_json` wrote.

        Raises:
            ValueError: It is none, or of another format.
        """
        if text is None:
            raise ValueError("it has no circumspect metadata")
        found = json.loads(text)
        if (kind := found.pop("format", None)) != FORMAT:
            raise ValueError(f"it is of format {kind}, this version reads format {FORMAT}")
        tuples = {name: tuple(found[name]) for name in ("shape", "classes", "counts")}
        return cls(**{**found, **tuples})


@dataclass(frozen=True, eq=False)
class Rows:
    """Some grids of a shard.

    Attributes:
        packed: (n, bytes) uint8 grids as packed bits.
        labels: (n,) int64.
        objects: (n,) names.
        starts_deg: (n,) [degrees]; NaN where there is none.
    """

    packed: NDArray[np.uint8]
    labels: NDArray[np.int64]
    objects: NDArray[np.str_]
    starts_deg: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.labels)

    def subset(self, chosen: NDArray[np.int64] | slice) -> Rows:
        """Those that an index array names."""
        return Rows(
            self.packed[chosen], self.labels[chosen], self.objects[chosen], self.starts_deg[chosen]
        )

    @classmethod
    def joined(cls, parts: Sequence[Rows]) -> Rows:
        """Of several, one after the other."""
        return cls(
            np.concatenate([part.packed for part in parts]),
            np.concatenate([part.labels for part in parts]),
            np.concatenate([part.objects for part in parts]),
            np.concatenate([part.starts_deg for part in parts]),
        )


def require_pyarrow() -> None:
    """Find out whether shards can be read and written.

    Raises:
        MissingExtraError: They can not.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("pyarrow", "cluster") from error


def write_shard(store: SetStore, head: ShardHead, rows: Rows) -> None:
    """Write a shard; it is there whole or not at all.

    Args:
        store: Of the set.
        head: What the shard holds.
        rows: The grids.

    Raises:
        InputError: The rows do not fit the head.
        MissingExtraError: pyarrow is not installed.
        OutputError: The file can not be written.
    """
    require_pyarrow()
    import pyarrow as pa
    from pyarrow import parquet

    if rows.packed.shape != (len(rows), head.grid_bytes) or rows.packed.dtype != np.uint8:
        raise InputError(f"grids {rows.packed.shape} are not {head.grid_bytes} bytes each")
    if len(rows) and not 0 <= rows.labels.min() <= rows.labels.max() < len(head.classes):
        raise InputError(f"labels lie outside the {len(head.classes)} classes")
    counts = np.bincount(rows.labels, minlength=len(head.classes))
    head = replace(head, counts=tuple(counts.tolist()))
    grids = pa.FixedSizeBinaryArray.from_buffers(
        pa.binary(head.grid_bytes), len(rows), [None, pa.py_buffer(rows.packed.tobytes())]
    )
    starts = pa.array(rows.starts_deg, pa.float64(), mask=np.isnan(rows.starts_deg))
    table = pa.table({
        "grid": grids, "label": pa.array(rows.labels, pa.int64()),
        "object": pa.array(rows.objects.tolist(), pa.string()), "start_deg": starts,
    }).replace_schema_metadata({KEY: head.to_json()})  # fmt: skip
    content = io.BytesIO()
    parquet.write_table(
        table, content, row_group_size=GROUP, compression="zstd", write_page_checksum=True
    )
    store.write(head.name, content.getvalue())


class ShardFile:
    """A shard to read from; only what is asked for is read.

    Args:
        store: Of the set.
        name: Of the file inside it.

    Attributes:
        head: What it holds.
        groups: Grids in each row group.

    Raises:
        InputError: The file is missing, truncated, or no shard.
        MissingExtraError: pyarrow is not installed.
    """

    def __init__(self, store: SetStore, name: str) -> None:
        require_pyarrow()
        from pyarrow import ArrowException, parquet

        self.place = store.place(name)
        stream = store.opened(name)
        try:
            self._file = parquet.ParquetFile(stream, page_checksum_verification=True)
            self.head = ShardHead.from_json((self._file.schema_arrow.metadata or {}).get(KEY))
            self._require_columns()
        except (ArrowException, OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            stream.close()
            raise InputError(f"{self.place}: is no whole shard ({_first_line(error)})") from error
        found = self._file.metadata
        self.groups = [found.row_group(n).num_rows for n in range(found.num_row_groups)]

    def _require_columns(self) -> None:
        import pyarrow as pa

        wanted = {
            "grid": pa.binary(self.head.grid_bytes), "label": pa.int64(), "object": pa.string(),
            "start_deg": pa.float64(),
        }  # fmt: skip
        found = self._file.schema_arrow
        for name, kind in wanted.items():
            if name not in found.names or found.field(name).type != kind:
                raise ValueError(f"its column {name} is not {kind}")

    def rows(self, group: int) -> Rows:
        """The grids of a row group.

        Raises:
            InputError: They are broken.
        """
        from pyarrow import ArrowException

        try:
            table = self._file.read_row_group(group)
            grids = table["grid"].combine_chunks()
            width = self.head.grid_bytes
            packed = np.frombuffer(grids.buffers()[1], np.uint8)[grids.offset * width :]
            rows = Rows(
                packed[: len(grids) * width].reshape(len(grids), width),
                table["label"].to_numpy(),
                np.array(table["object"].to_pylist(), np.str_),
                table["start_deg"].fill_null(np.nan).to_numpy(),
            )
        except (ArrowException, OSError, ValueError) as error:
            raise InputError(f"{self.place}: is broken ({_first_line(error)})") from error
        if len(rows) and not 0 <= rows.labels.min() <= rows.labels.max() < len(self.head.classes):
            raise InputError(f"{self.place}: labels lie outside its classes")
        return rows

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
