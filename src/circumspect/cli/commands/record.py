"""`circumspect record`."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from circumspect.errors import InputError, printable

if TYPE_CHECKING:
    from rich.table import Table

    from circumspect.recording.bag import Bag, Topic

SECOND = 1e9
"""Nanoseconds in a second."""
ENDLESS = 100_000
"""Width of an output that is no terminal [columns], so that lines are not wrapped."""


@dataclass(frozen=True)
class Record:
    """Show the contents of a recording, and how `replay` would use it.

    $ circumspect record info run.mcap
    $ circumspect record info robot.bag --json

    To make a recording, use `circumspect scan OBJECT --record FILE`.
    """

    what: tyro.conf.Positional[Literal["info"]]
    """info: print the contents of the file."""
    recording: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """MCAP file, or bag of ROS 2 (folder or db3 file) or ROS 1."""
    json: bool = False
    """Print one JSON object on standard output and nothing else."""

    def run(self) -> int:
        """Read the bag and print its contents."""
        from circumspect.recording import is_bag, open_bag
        from circumspect.recording.open_recording import require_known_kind

        if not is_bag(self.recording):
            require_known_kind(self.recording)
            raise InputError(f"{self.recording}: is no bag (.mcap, .db3, .bag or a bag's folder)")
        document = facts(open_bag(self.recording))
        if self.json:
            print(json.dumps(document))  # noqa: T201
        else:
            _show(document)
        return 0


def facts(bag: Bag) -> dict[str, Any]:
    """The contents of a bag, in JSON types."""
    from circumspect.recording.topic_choice import TopicNames, choose_topics, require_info

    replayed: dict[str, Any] | str
    try:
        topics = choose_topics(bag, TopicNames())
        require_info(bag, topics)
        replayed = asdict(topics)
    except InputError as error:
        replayed = str(error)
    notes: dict[str, Any] = dict(bag.notes)
    # The file is untrusted: values that are not JSON stay text.
    with suppress(KeyError, ValueError, RecursionError):
        notes["config"] = json.loads(notes["config"])
    return {
        "recording": str(bag.path),
        "kind": bag.kind,
        "bytes": _size(bag.path),
        "seconds": _span([t for t in bag.topics.values() if t.count]),
        "broken": bag.error,
        "damaged": bag.damage,
        "topics": {name: asdict(topic) for name, topic in sorted(bag.topics.items())},
        "replay": replayed,
        "notes": notes,
    }


def _size(path: Path) -> int:
    files = [path] if path.is_file() else [file for file in path.iterdir() if file.is_file()]
    return sum(file.stat().st_size for file in files)


def _span(topics: list[Topic]) -> float | None:
    firsts = [topic.first for topic in topics if topic.first is not None]
    lasts = [topic.last for topic in topics if topic.last is not None]
    return (max(lasts) - min(firsts)) / SECOND if firsts and lasts else None


def _show(document: dict[str, Any]) -> None:
    from circumspect.cli.console import OutputConsole

    console = OutputConsole(highlight=False)
    if not console.is_terminal:
        # A file or a pipe has no width: one line per statement.
        console.width = ENDLESS
    seconds = document["seconds"]
    span = "" if seconds is None else f", {seconds:.1f} s"
    console.print(
        f"{document['recording']}: {document['kind']}, {document['bytes'] / 1e6:.1f} MB{span}",
        soft_wrap=True, markup=False,
    )  # fmt: skip
    if document["broken"]:
        damage = printable(document["broken"])
        console.print(f"It is {damage}; everything before it can be replayed.", markup=False)
    if document["damaged"]:
        console.print(f"It has {document['damaged']}; a replay skips them.", markup=False)
    console.print(_table(document["topics"], seconds))
    replay = document["replay"]
    if isinstance(replay, str):
        console.print(f"A replay needs help: {printable(replay)}", markup=False)
        return
    used = {k: v for k, v in replay.items() if v and k != "transforms"}
    names = ", ".join(f"{v} ({k})" for k, v in used.items())
    console.print(f"Replayed are {printable(names)}", markup=False)
    if not replay["odometry"]:
        console.print("There is no odometry: frames are found by registration alone.")


def _table(topics: dict[str, Any], seconds: float | None) -> Table:
    """Table of topics with complete names, to be copied into flags."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for name in ("topic", "type"):
        table.add_column(name, overflow="fold")
    for name in ("messages", "per second"):
        table.add_column(name, justify="right", no_wrap=True)
    for name, topic in topics.items():
        rate = f"{(topic['count'] - 1) / seconds:.1f}" if seconds and topic["count"] > 1 else ""
        kind = topic["kind"].replace("/msg/", "/")
        table.add_row(_plain(name), _plain(kind), str(topic["count"]), rate)
    return table


def _plain(name: str) -> str:
    """An untrusted name without markup and terminal commands."""
    from rich.markup import escape

    return escape(printable(name))
