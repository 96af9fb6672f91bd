"""`circumspect data`."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from circumspect.cli.commands.convert import Conversion
from circumspect.cli.config_file import ConfigFlag, write_config_to
from circumspect.cli.given_flags import given_flags
from circumspect.errors import InputError, printable

SHOWN = 8
"""Largest number of names in each printed list; --json prints all."""


@dataclass(frozen=True)
class Data:
    """Download ModelNet10, verify data sets, import meshes, convert sets to shards.

    $ circumspect data fetch modelnet10
    $ circumspect data verify ModelNet10
    $ circumspect data import sweethome3d FOLDER --out sweethome3d.npz
    $ circumspect data convert ModelNet10 --out shards
    """

    what: tyro.conf.Positional[Literal["fetch", "verify", "import", "convert"]]
    """fetch: download and unpack; an interrupted download resumes. verify: count the objects of
    every class and split, and list missing, foreign and broken ones; missing objects of your own
    classes are not detected. import: read the models of catalogues, with real sizes and labels,
    into one mesh pack. convert: write the grids of a set in shards, a stream of any length."""
    which: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SET")]
    """Set to fetch (modelnet10), kind of catalogue to import (sweethome3d), or folder to verify or
    convert: point packs, files as <class>/{train,test}/* in any readable format, or a set made by
    `circumspect gather`, also in an object store."""
    path: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[PATH]")] = None
    """import only: a .sh3f file, or a folder that is searched for such files and for the jar of
    Sweet Home 3D."""
    out: str | None = None
    """fetch: parent of the folder ModelNet10, by default the current folder. import: mesh pack, by
    default sweethome3d.npz. convert: folder, or URL such as s3://bucket/set, by default shards."""
    url: str | None = None
    """fetch only: URL to use instead of the public archive."""
    sha256: str | None = None
    """fetch only: SHA-256 of the archive; that of the public archive is known."""
    conversion: Conversion = field(default_factory=Conversion)
    """Settings of convert."""
    json: bool = False
    """Print one JSON object on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Run the requested action; exit code 1 if something is missing or broken."""
        if self.what != "convert" and (misplaced := given_flags(self, "conversion")):
            raise InputError(f"{misplaced[0]} belongs to data convert; leave it out")
        if self.what == "import":
            return self._import()
        if self.path is not None:
            raise InputError(f"data {self.what} takes one SET and no further path: '{self.path}'")
        if self.what == "verify":
            return self._verify(Path(self.which))
        if self.what == "convert":
            return self._convert()
        path = self._fetched()
        try:
            return self._verify(path)
        except InputError as error:
            # The folder existed before: an unpacked archive has at least one mesh.
            raise InputError(f"{error}; remove it, or fetch to another folder by --out") from error

    def _convert(self) -> int:
        from circumspect.cli.commands.convert import convert_set

        if misplaced := given_flags(self, "url", "sha256"):
            raise InputError(f"{misplaced[0]} belongs to data fetch; leave it out")
        out = self.out or "shards"

        def begun() -> None:
            write_config_to(out, self, "data convert")

        counts = convert_set(self.which, out, self.conversion, begun)
        if self.json:
            print(json.dumps({"shards": out, **counts}))  # noqa: T201
            return 0
        left_out = counts.pop("left out")
        sizes = ", ".join(f"{count:,} {split}" for split, count in counts.items())
        print(f"{out}: grids: {sizes}")  # noqa: T201
        if left_out:
            print(f"{left_out} objects span no shape and are left out")  # noqa: T201
        return 0

    def _import(self) -> int:
        from circumspect.cli.commands.import_sweethome3d import import_catalogues

        if self.which.lower() != "sweethome3d":
            raise InputError(f"no data set '{self.which}' to import; known: sweethome3d")
        if self.path is None:
            raise InputError(
                "data import sweethome3d needs a PATH: a .sh3f file, or a folder of them"
            )
        if misplaced := given_flags(self, "url", "sha256"):
            raise InputError(f"{misplaced[0]} belongs to data fetch; leave it out")
        return import_catalogues(self.path, Path(self.out or "sweethome3d.npz"), self.json)

    def _fetched(self) -> Path:
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.fetching import URL, fetch_modelnet10

        if self.which.lower() != "modelnet10":
            raise InputError(f"no data set '{self.which}' to fetch; known: modelnet10")
        with progress_bar("ModelNet10", of_bytes=True) as progress:
            return fetch_modelnet10(
                Path(self.out or ""), self.url or URL, self.sha256, progress=progress
            )

    def _verify_gathered(self, path: Path) -> int:
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.gathered_verification import verify_gathered

        with progress_bar("scans") as progress:
            found = verify_gathered(path, progress)
        document = {"folder": str(path), **found.to_dict()}
        print(json.dumps(document) if self.json else _readable_gathered(document))  # noqa: T201
        return 0 if found.complete else 1

    def _verify(self, path: Path) -> int:
        from circumspect.cli.progress import progress_bar
        from circumspect.datasets.gathered_set import is_gathered
        from circumspect.datasets.own_verification import has_own_classes, verify_own
        from circumspect.datasets.verification import verify

        if is_gathered(path):
            return self._verify_gathered(path)
        with progress_bar("files") as progress:
            found = verify_own(path, progress) if has_own_classes(path) else verify(path, progress)
        document = {"folder": str(path), **found.to_dict()}
        print(json.dumps(document) if self.json else _readable(document))  # noqa: T201
        return 0 if found.complete else 1


def _readable_gathered(document: dict[str, Any]) -> str:
    counts = document["counts"]
    lines = [f"{'class':14}{'train':>12}{'test':>12}"]
    for name in sorted({key.split("/")[1] for key in counts}):
        cells = [str(counts.get(f"{split}/{name}", 0)) for split in ("train", "test")]
        lines.append(f"{name:14}{cells[0]:>12}{cells[1]:>12}")
    return "\n".join([*lines, *_problems(document)])


def _readable(document: dict[str, Any]) -> str:
    from circumspect.datasets.verification import MODELNET10

    train, test = (document["counts"][split] for split in ("train", "test"))
    own = document.get("own_classes", False)
    lines = [f"{'class':14}{'train':>12}{'test':>12}"]
    for name in train:
        cells = [str(train[name]), str(test[name])]
        if not own:
            cells = [
                f"{cell} of {all_}" for cell, all_ in zip(cells, MODELNET10[name], strict=True)
            ]
        lines.append(f"{printable(name):14}{cells[0]:>12}{cells[1]:>12}")
    return "\n".join([*lines, *_problems(document)])


def _problems(document: dict[str, Any]) -> list[str]:
    """Lists of missing, broken and foreign objects, and whether the set is complete."""
    broken = [entry["error"] for entry in document["broken"]]
    lines = []
    for what, entries in (
        ("missing", document["missing"]), ("broken", broken), ("foreign", document["foreign"]),
        ("never saw their object", document.get("without_cloud", [])),
    ):  # fmt: skip
        if entries:
            more = len(entries) - SHOWN
            rest = f", and {more} more (all with --json)" if more > 0 else ""
            lines.append(f"{what}: {', '.join(map(printable, entries[:SHOWN]))}{rest}")
    state = "complete" if document["complete"] else "not complete"
    if document.get("own_classes"):
        # The complete list of objects is unknown.
        readable = "all of it can be read" if document["complete"] else "not all of it can be read"
        state = f"classes of your own, not ModelNet10's; {readable}"
        if not document["complete"] and not document["broken"]:
            state = "no object can be read"
    lines.append(f"{printable(document['folder'])}: {state}")
    return lines
