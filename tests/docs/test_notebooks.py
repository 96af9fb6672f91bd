"""The notebooks run from their first cell to their last, and are stored without outputs."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
NEEDS = {"replay_a_recording": ("rosbags", "mcap")}
"""Packages of extras, by notebook."""


@pytest.fixture(scope="module")
def pages():
    """The module that executes notebooks for the documentation."""
    pytest.importorskip("matplotlib", reason='needs pip install "circumspect[sim]"')
    spec = importlib.util.spec_from_file_location("notebook_pages", DOCS / "notebook_pages.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def cells_of(file):
    notebook = json.loads(file.read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    return notebook["cells"]


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_notebook_runs(file, pages):
    for package in NEEDS.get(file.stem, ()):
        pytest.importorskip(package)
    outputs = pages.executed(cells_of(file)).values()
    assert any(output.text for output in outputs)
    assert any(output.figures for output in outputs)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_notebook_is_stored_without_outputs(file):
    cells = cells_of(file)
    assert "".join(cells[0]["source"]).startswith("# Notebook: ")
    assert len({cell["id"] for cell in cells}) == len(cells)
    for cell in cells:
        if cell["cell_type"] == "code":
            assert (cell["execution_count"], cell["outputs"]) == (None, [])


def test_last_expressions_and_figures_are_shown(pages):
    code = "import matplotlib.pyplot as plt\nplt.figure(figsize=(1, 1))\nprint('a')\n6 * 7"
    cells = [
        {"cell_type": "markdown", "source": ["# Title"]},
        {"cell_type": "code", "source": [code]},
    ]
    page = pages.notebook_page(json.dumps({"cells": cells}))
    assert page.startswith("# Title\n\n```python\nimport")
    assert "```text\na\n42\n```" in page
    assert page.count("data:image/png") == 1


def test_page_of_a_missing_package_has_no_outputs(pages):
    cells = [{"cell_type": "code", "source": ["import no_such_package_at_all"]}]
    page = pages.notebook_page(json.dumps({"cells": cells}))
    assert page == "```python\nimport no_such_package_at_all\n```"


def test_there_are_notebooks():
    assert len(NOTEBOOKS) >= 3
