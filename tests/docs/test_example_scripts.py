"""The examples run, stay short, and use public names alone."""

import ast
import importlib
import re
import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))
SMALL = {"04": ["6"], "05": ["4"], "06": ["1"]}
"""Arguments that make the longer ones short."""
EXPECTED = {
    "00": r"^turned by 222.5 deg: chair \(\d+ %\)",
    "01": r" 90.0 deg is 8.00 cells: (100|9\d)% are where a shift puts them; of the cube's +[1-6]?\d%",
    "02": r"turned by 100.0 deg; estimated from the spectra: (99|100|101)\.\d deg",
    "03": r"^11: +\d+ px, +100% coverage, toilet",
    "04": r"^path known within \d\.\d mm$",
    "05": r"^the limit of 4 frames is reached: \w+$",
    "06": r"^modelnet10 +accuracy",
}


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_each_example_prints_its_expected_result(file, tmp_path, monkeypatch, capsys):
    number = file.name[:2]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(file), *SMALL.get(number, [])])
    runpy.run_path(str(file), run_name="__main__")
    assert re.search(EXPECTED[number], capsys.readouterr().out, re.M)


def test_examples_are_numbered_from_0_and_short():
    assert [file.name[:2] for file in EXAMPLES] == sorted(EXPECTED)
    for file in EXAMPLES:
        assert len(file.read_text().splitlines()) < 80, file.name


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_examples_use_public_names_only(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("circumspect"):
            package = importlib.import_module(node.module)
            assert node.module.count(".") == 1, node.module
            assert {name.name for name in node.names} <= set(package.__all__), node.module
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", None) == "cs":
            assert node.attr in importlib.import_module("circumspect").__all__
