"""`circumspect doctor`: installed, broken and missing parts, and how to install them."""

from __future__ import annotations

import json
import os
import platform
import re
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

from circumspect.cli.model_flag import NAMES
from circumspect.errors import printable

DATA = ("ModelNet10", "modelnet10", "redkitchen")
"""Data folders that are searched in the current folder and in $CIRCUMSPECT_DATA."""
RUNTIME = "runtime"
FOR = {
    RUNTIME: "classify, grid, replay of folders",
    "figures": "pictures and figures",
    "sim": "demo, scan, gather: the simulated robot",
    "train": "train, export, nets",
    "data": "data fetch",
    "formats": "files of LAS, LAZ, E57, and GLB with Draco",
    "usd": "files of USD and USDZ",
    "bags": "--record, replay of bags",
    "locate": "locate: ceiling cameras",
    "viewer": "view, --viewer: the dashboard",
    "ros2": "ros2: the node",
    "realsense": "watch: RealSense cameras",
    "cluster": "--cluster: jobs on Ray",
    "docs": "make docs",
}
"""Extra to its purpose."""
NOT_SHOWN = ("all", "test")
ENTRY = re.compile(r"([\w.-]+)(?:\[([\w,-]+)\])?[^;]*(?:;.*extra == [\"']([\w-]+)[\"'])?")


@dataclass(frozen=True)
class Check:
    """Result of a check.

    Attributes:
        what: What is checked.
        works: Whether it works.
        outcome: The result, or the error.
    """

    what: str
    works: bool
    outcome: str


def self_test() -> list[Check]:
    """Run all checks; errors are reported, not raised."""
    classifiers = (_checked(f"classifier {name}", partial(_classifier, name)) for name in NAMES)
    return [_checked("native kernels", _kernels), *classifiers]


def _checked(what: str, check: Callable[[], str]) -> Check:
    try:
        return Check(what, True, check())
    # The user needs any error that a broken installation raises.
    except Exception as error:
        return Check(what, False, f"{type(error).__name__}: {error}")


def _kernels() -> str:
    """Compare a grid of the compiled kernel with that of NumPy."""
    import numpy as np

    from circumspect.furniture import make_furniture
    from circumspect.grid import CylindricalGrid, numpy_twin

    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    bounds = CylindricalGrid.fit(cloud)
    began = time.perf_counter()
    states = bounds.hits(cloud).states
    spent = 1e3 * (time.perf_counter() - began)
    if not np.array_equal(states, numpy_twin.hits(bounds, cloud.points_xyz).states):
        raise ArithmeticError("they differ from the same in NumPy; install circumspect again")
    return f"agree with NumPy; {spent:.1f} ms for 20,000 points"


def _classifier(name: str) -> str:
    """Classify a procedural chair."""
    from circumspect.classification import Classifier
    from circumspect.furniture import make_furniture

    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    began = time.perf_counter()
    prediction = Classifier.load(name).classify(cloud)
    spent = 1e3 * (time.perf_counter() - began)
    if prediction.label != "chair":
        raise ArithmeticError(f"it calls a chair {prediction.label}; install circumspect again")
    return f"names a chair ({prediction.probability:.2f}); {spent:.0f} ms with loading"


@dataclass(frozen=True)
class Doctor:
    """Check the installation: working parts, missing extras, and how to install them.

    $ circumspect doctor
    $ circumspect doctor --json

    The exit code is 1 if a part that every command needs is missing or fails.
    """

    json: bool = False
    """Print one JSON object on standard output and nothing else."""

    def run(self) -> int:
        """Run all checks and print a table."""
        extras, checks = installed(), self_test()
        document = {
            **_machine(),
            "extras": extras,
            "checks": [asdict(check) for check in checks],
            "plugins": _plugins(),
        }
        if self.json:
            print(json.dumps(document))  # noqa: T201
        else:
            _show(document)
        works = all(extras[RUNTIME].values()) and all(check.works for check in checks)
        return 0 if works else 1


def _machine() -> dict[str, Any]:
    from circumspect import __version__
    from circumspect.datasets.cache_folder import cache_folder

    cache = cache_folder(".")
    places = (Path(), Path(os.environ.get("CIRCUMSPECT_DATA", ".")))
    found = {str(place / name) for place in places for name in DATA if (place / name).is_dir()}
    return {
        "circumspect": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count(),
        "cache": {"folder": str(cache), "bytes": _size(cache)},
        "data": sorted(found),
    }


def _plugins() -> list[dict[str, str | None]]:
    """Networks, view planners and readers of installed packages."""
    from circumspect.geometry.formats.cloud_files import READER_REGISTRY
    from circumspect.planning import PLANNER_REGISTRY

    found = [*PLANNER_REGISTRY.plugins(), *READER_REGISTRY.plugins()]
    try:
        from circumspect.nets.registry import NETWORKS
    except ImportError:
        # Networks need torch; the table of extras reports that it is missing.
        return [plugin.to_dict() for plugin in found]
    return [plugin.to_dict() for plugin in (*NETWORKS.plugins(), *found)]


def _show_plugins(plugins: list[dict[str, str | None]]) -> None:
    from rich.text import Text

    from circumspect.cli.console import OutputConsole

    console = OutputConsole(highlight=False)
    for plugin in plugins:
        works = plugin["error"] is None
        mark = "[green]works [/green]" if works else "[red]BROKEN[/red]"
        text = f"{plugin['kind']} {plugin['name']} of {plugin['distribution']}"
        text = text if works else str(plugin["error"])
        console.print(
            Text.from_markup(f"{mark}  plug-in: "), Text(printable(text)), sep="", soft_wrap=True
        )


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def _show(document: dict[str, Any]) -> None:
    from rich.table import Table

    from circumspect.cli.console import OutputConsole

    console = OutputConsole(highlight=False)
    console.print(
        f"[bold]circumspect {document['circumspect']}[/bold], Python {document['python']}, "
        f"{document['cores']} cores\n{document['platform']}",
        soft_wrap=True,
    )
    console.print()
    for check in document["checks"]:
        mark = "[green]works [/green]" if check["works"] else "[red]BROKEN[/red]"
        console.print(f"{mark}  {check['what']}: ", check["outcome"], sep="", soft_wrap=True)
    _show_plugins(document["plugins"])
    table = Table("extra", "", "what for", "packages", box=None, pad_edge=False)
    lacking = []
    for extra, packages in document["extras"].items():
        missing = [name for name, version in packages.items() if version is None]
        lacking += [extra] if missing else []
        versions = ", ".join(f"{name} {found or '-'}" for name, found in packages.items())
        state = "[yellow]missing[/yellow]" if missing else "[green]there[/green]"
        table.add_row(extra, state, FOR.get(extra, ""), versions)
    console.print()
    console.print(table)
    console.print()
    cache = document["cache"]
    console.print(f"cache: {cache['folder']} ({cache['bytes'] / 1e6:.0f} MB)", soft_wrap=True)
    data = ", ".join(document["data"]) or "none here; get some: circumspect data fetch modelnet10"
    console.print(f"data: {data}", soft_wrap=True)
    for extra in lacking:
        console.print(
            f"get what {extra} lacks: ", remedy(extra), sep="", markup=False, soft_wrap=True
        )


def installed() -> dict[str, dict[str, str | None]]:
    """Extra to package to version, from the metadata of the package; None if it is missing."""
    found: dict[str, dict[str, str | None]] = {RUNTIME: {}}
    for extra in metadata.metadata("circumspect").get_all("Provides-Extra") or ():
        if extra not in NOT_SHOWN:
            found[extra] = {}
    for entry in metadata.requires("circumspect") or ():
        match = ENTRY.match(entry)
        if match is not None and match[1] != "circumspect" and (match[3] or RUNTIME) in found:
            found[match[3] or RUNTIME][match[1]] = version(match[1])
    return found


def version(package: str) -> str | None:
    """The version of an installed package, else None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def remedy(extra: str) -> str:
    """The command that installs an extra."""
    return "pip install circumspect" if extra == RUNTIME else f'pip install "circumspect[{extra}]"'
