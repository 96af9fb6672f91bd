import ast
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import circumspect


@pytest.mark.parametrize("name", circumspect.__all__)
def test_every_public_name_resolves_and_is_documented(name):
    value = getattr(circumspect, name)
    assert value.__doc__
    assert name in dir(circumspect)


def test_all_of_every_package_resolves():
    names = [module.name for module in pkgutil.walk_packages(circumspect.__path__, "circumspect.")]
    found = [importlib.import_module(name) for name in names if not name.endswith("__main__")]
    # Once all are imported: a module takes the place of a name that is found when it is first used.
    for module in found:
        for name in getattr(module, "__all__", ()):
            assert not isinstance(getattr(module, name), ModuleType | None)


def test_unknown_names_of_a_package_are_attribute_errors():
    import circumspect.training

    with pytest.raises(AttributeError, match="colour"):
        circumspect.training.colour  # noqa: B018


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="colour"):
        circumspect.colour  # noqa: B018


def test_import_loads_no_other_packages():
    code = "import sys, circumspect; print(*sorted(m for m in sys.modules if 'circumspect.' in m))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []


EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("[0-9]*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_imports_from_two_packages_beside_the_top_at_most(example):
    tree = ast.parse(example.read_text())
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert len({name for name in modules if name and name.startswith("circumspect.")}) <= 2
    assert "circumspect" not in modules, "examples import circumspect as cs"


def test_api_page_lists_every_public_name():
    page = (Path(__file__).parents[1] / "docs" / "api" / "index.md").read_text()
    listed = {line.split(".")[-1] for line in page.splitlines() if line.startswith("   circum")}
    assert listed == set(circumspect.__all__)
