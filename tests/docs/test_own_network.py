"""The guide "Bring your own network": its package, up to its rows in both tables."""

import re
import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from installed_package import forget_plugins, install
from little_furniture_packs import write_packs
from made_crops import write_crops

from circumspect.cli.main import main
from circumspect.furniture import make_furniture
from circumspect.planning import make_planner
from circumspect_experiments import real

PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "own_network"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The example as pip would install it."""
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())
    folder = tmp_path / "site"
    folder.mkdir()
    modules = {file.stem: file.read_text() for file in PACKAGE.glob("*.py")}
    assert sorted(modules) == sorted(project["tool"]["setuptools"]["py-modules"])
    about = project["project"]
    install(folder, monkeypatch, modules, about["entry-points"], about["name"], about["version"])
    yield folder
    forget_plugins()


def rows_of(table, name):
    return re.findall(rf"^\| {name} +\|.*\|$", table.read_text(), re.M)


def test_network_gets_its_row_in_both_tables(installed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(real, "REPLICAS", 1)
    write_packs(tmp_path / "packs", train=2)
    data, quick = ["--data", "packs"], ["--epochs", "1"]
    flags = [*data, "--nets", "ringnet", *quick, "--yaw-count", "1", "--out", "rivals"]
    # The others are measured in tests of their own.
    assert main(["reproduce", "rivals", *flags, "--only", "ringnet"]) == 0
    assert rows_of(tmp_path / "rivals" / "rivals.md", "ringnet")
    assert "--nets ringnet --epochs 1" in capsys.readouterr().out
    write_crops(tmp_path / "rooms.npz")
    flags = ["--crops", "rooms.npz", "--nets", "ringnet", *data, *quick, "--out", "real"]
    assert main(["reproduce", "real", *flags]) == 0
    assert rows_of(tmp_path / "real" / "real.md", "ringnet")


def test_network_that_is_not_installed_is_trained_evaluated_and_exported(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(sys, "path", list(sys.path))
    forget_plugins()
    shutil.copy(PACKAGE / "own_network.py", tmp_path / "loose_network.py")
    monkeypatch.chdir(tmp_path)
    write_packs(tmp_path / "packs")
    net = ["--net", "loose_network:RINGNET"]
    quick = ["--epochs", "1", "--replicas", "1", "--no-validation"]
    assert main(["train", *net, "--data", "packs", "--out", "run", *quick]) == 0
    capsys.readouterr()
    # Another process knows the file alone.
    forget_plugins()
    assert main(["export", "run", "ring.onnx"]) == 2
    assert "made with the network 'ringnet', which is not installed" in capsys.readouterr().err
    assert main(["export", "run", "ring.onnx", *net]) == 0
    evaluate = ["evaluate", "--data", "packs", "--split", "test", "--yaw", "0", "--json"]
    assert main([*evaluate, "--model", "run", *net]) == 0
    forget_plugins()
    assert main([*evaluate, "--model", "ring.onnx"]) == 0
    assert main([*evaluate, "--model", "run"]) == 2
    forget_plugins()


def test_planner_and_reader_of_the_package(installed, tmp_path, capsys):
    assert type(make_planner("zigzag")).__name__ == "Zigzag"
    cloud = make_furniture("chair", 3).sampled(4000, 0).points_xyz
    np.savetxt(tmp_path / "chair.asc", cloud, delimiter=";")
    assert main(["classify", str(tmp_path / "chair.asc"), "--model", "modelnet10"]) == 0
    assert "chair.asc: chair (" in capsys.readouterr().out
