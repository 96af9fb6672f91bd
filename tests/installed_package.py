"""A package with plug-ins, installed as pip would do it: modules and entry points on the path."""

import importlib
import sys

from circumspect.geometry.formats.cloud_files import READER_REGISTRY
from circumspect.planning import PLANNER_REGISTRY


def forget_plugins():
    """Clear the registries, which keep loaded plug-ins for the lifetime of a process."""
    registries = [READER_REGISTRY, PLANNER_REGISTRY]
    if "circumspect.nets.registry" in sys.modules:
        registries.append(sys.modules["circumspect.nets.registry"].NETWORKS)
    for registry in registries:
        registry.forget()


def install(folder, monkeypatch, modules, groups, name="spare-parts", version="1.2"):
    """Make a package importable and its entry points known, for one test.

    Args:
        folder: Where it is made.
        monkeypatch: Undoes it.
        modules: Name to source.
        groups: Group to entry points, such as {"circumspect.nets": {"tiny": "my_net:TINY"}}.
        name: Of the distribution.
        version: Of the distribution.
    """
    for module, source in modules.items():
        (folder / f"{module}.py").write_text(source)
        monkeypatch.delitem(sys.modules, module, raising=False)
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    lines = []
    for group, entries in groups.items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in entries.items()), ""]
    (info / "entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(folder)
    importlib.invalidate_caches()
    forget_plugins()
