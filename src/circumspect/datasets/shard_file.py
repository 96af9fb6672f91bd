"""Shards of a set of grids: self-describing Parquet files.

| column | content |
|---|---|
| grid | the views of an object as packed bits |
| label | index into the classes |
| object | name of the object, shared by its variants and scans |
| start_deg | azimuth of the scan's start [degrees]; null without a scan |

The schema's metadata "circumspect" contain a `ShardHead` as JSON.
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

from circumspect.classification.input_spec_dict import with_current_names
from circumspect.datasets.set_store import SetStore
from circumspect.errors import InputError, MissingExtraError

FORMAT = 3
"""Version of the head. Version 3 renamed "recipe" to "input_spec"."""
KEY = b"circumspect"
GROUP = 512
"""Number of grids in a row group, the unit of reading."""


@dataclass(frozen=True)
class ShardHead:
    """The properties that all grids of a shard share; JSON types.

    Attributes:
        input_spec: Specification of the grids, see `input_spec_from_dict`.
        shape: Number of views of an object, and cells along each axis of a grid.
        classes: Class names in the order of the labels.
        source: Source of the objects and settings of the variants.
        split: "train", "validation" or "test".
        number: Number of the shard, from 0.
        count: Number of shards in the split.
        version: Version of circumspect.
        counts: Number of grids of each class; `write_shard` counts them.
    """

    input_spec: dict[str, Any]
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
        """Name of the shard's file inside the set."""
        return f"{self.split}/{self.number:05}-of-{self.count:05}.parquet"

    @property
    def grid_bytes(self) -> int:
        """Size of one packed grid."""
        return -(-int(np.prod(self.shape)) // 8)

    @property
    def digest(self) -> str:
        """Hash of everything that defines the split; the same for all of its shards."""
        # Sets of format 2 and networks trained on them keep their digests.
        grids = {"staggered" if k == "dithered" else k: v for k, v in self.input_spec.items()}
        content = json.dumps([grids, self.source, self.split, self.count], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    def to_json(self) -> str:
        """The text in the file's metadata."""
        return json.dumps({"format": FORMAT, **asdict(self)})

    @classmethod
    def from_json(cls, text: bytes | None) -> ShardHead:
        """Read a text from `to_json`, also of format 2.

        Raises:
            ValueError: The text is missing, or of another format.
        """
        if text is None:
            raise ValueError("it has no circumspect metadata")
        found = json.loads(text)
        if (kind := found.pop("format", None)) not in (2, FORMAT):
            raise ValueError(f"it is of format {kind}, this version reads formats 2 and {FORMAT}")
        if kind == 2:
            found["input_spec"] = with_current_names(found.pop("recipe"))
        tuples = {name: tuple(found[name]) for name in ("shape", "classes", "counts")}
        return cls(**{**found, **tuples})


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a shard.

    Attributes:
        packed: (n, bytes) uint8 grids as packed bits.
        labels: (n,) int64 labels.
        objects: (n,) names of the objects.
        starts_deg: (n,) azimuths of the starts [degrees]; NaN for none.
    """

    packed: NDArray[np.uint8]
    labels: NDArray[np.int64]
    objects: NDArray[np.str_]
    starts_deg: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.labels)

    def subset(self, chosen: NDArray[np.int64] | slice) -> Rows:
        """The rows of an index array."""
        return Rows(
            self.packed[chosen], self.labels[chosen], self.objects[chosen], self.starts_deg[chosen]
        )

    @classmethod
    def joined(cls, parts: Sequence[Rows]) -> Rows:
        """Concatenate rows."""
        return cls(
            np.concatenate([part.packed for part in parts]),
            np.concatenate([part.labels for part in parts]),
            np.concatenate([part.objects for part in parts]),
            np.concatenate([part.starts_deg for part in parts]),
        )


def require_pyarrow() -> None:
    """Check that shards can be read and written.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("pyarrow", "cluster") from error


def write_shard(store: SetStore, head: ShardHead, rows: Rows) -> None:
    """Write a shard atomically.

    Args:
        store: Storage of the set.
        head: Head of the shard.
        rows: The grids.

    Raises:
        InputError: The rows do not match the head.
        MissingExtraError: pyarrow is not installed.
        OutputError: The file cannot be written.
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
    """Reader of a shard; only the requested parts are read.

    Args:
        store: Storage of the set.
        name: Name of the file inside the set.

    Attributes:
        head: Head of the shard.
        groups: Number of grids in each row group.

    Raises:
        InputError: The file is missing, truncated, or not a shard.
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
        """Close the file."""
        self._file.close()


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
