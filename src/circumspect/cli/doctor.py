"""`circumspect doctor`: what is installed and works, what is missing, how to get it."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from circumspect.errors import printable

DATA = ("ModelNet10", "modelnet10", "redkitchen")
"""Folders that are looked for here and in $CIRCUMSPECT_DATA."""


@dataclass(frozen=True)
class Doctor:
    """What is installed and works, which extras are missing, and how to get them.

    $ circumspect doctor
    $ circumspect doctor --json

    The exit code is 1 where something that every command needs is missing or fails.
    """

    json: bool = False
    """One JSON object and nothing else on standard output."""

    def run(self) -> int:
        """Look, try, tell."""
        from circumspect.cli.installed import RUNTIME, installed
        from circumspect.cli.self_test import self_test

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
    from circumspect.geometry.cloud_files import READER_REGISTRY
    from circumspect.planning import PLANNER_REGISTRY

    found = [*PLANNER_REGISTRY.plugins(), *READER_REGISTRY.plugins()]
    try:
        from circumspect.nets.registry import NETWORKS
    except ImportError:
        # Without torch there are no networks; the table of extras says so.
        return [plugin.to_dict() for plugin in found]
    return [plugin.to_dict() for plugin in (*NETWORKS.plugins(), *found)]


def _show_plugins(plugins: list[dict[str, str | None]]) -> None:
    from rich.text import Text

    from circumspect.cli.console import OutputConsole

    console = OutputConsole(highlight=False)
    for plugin in plugins:
        works = plugin["error"] is None
        mark = "[green]works [/green]" if works else "[red]BROKEN[/red]"
        told = f"{plugin['kind']} {plugin['name']} of {plugin['distribution']}"
        told = told if works else str(plugin["error"])
        console.print(
            Text.from_markup(f"{mark}  plug-in: "), Text(printable(told)), sep="", soft_wrap=True
        )


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def _show(document: dict[str, Any]) -> None:
    from rich.table import Table

    from circumspect.cli.console import OutputConsole
    from circumspect.cli.installed import FOR, remedy

    console = OutputConsole(highlight=False)
    console.print(
        f"[bold]circumspect {document['circumspect']}[/bold], Python {document['python']}, "
        f"{document['cores']} cores\n{document['platform']}",
        soft_wrap=True,
    )
    console.print()
    for check in document["checks"]:
        mark = "[green]works [/green]" if check["works"] else "[red]BROKEN[/red]"
        console.print(f"{mark}  {check['what']}: ", check["told"], sep="", soft_wrap=True)
    _show_plugins(document["plugins"])
    table = Table("extra", "", "what for", "packages", box=None, pad_edge=False)
    lacking = []
    for extra, packages in document["extras"].items():
        missing = [name for name, version in packages.items() if version is None]
        lacking += [extra] if missing else []
        told = ", ".join(f"{name} {found or '-'}" for name, found in packages.items())
        state = "[yellow]missing[/yellow]" if missing else "[green]there[/green]"
        table.add_row(extra, state, FOR.get(extra, ""), told)
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
