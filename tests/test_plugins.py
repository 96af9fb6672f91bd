"""Plug-ins by entry point and by MODULE:NAME, and those that do not work."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from installed_package import forget_plugins, install

from circumspect.cli.main import main
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.geometry import read_cloud, write_ply
from circumspect.geometry.formats.cloud_files import READER_REGISTRY
from circumspect.planning import (
    PLANNER_REGISTRY,
    PLANNERS,
    CirclePlanner,
    ConfidencePlanner,
    make_planner,
)
from circumspect.plugins import PluginError, Registry

NET = """
from torch import nn
from circumspect.classification import GridSpec
from circumspect.nets import NetSpec

def build(classes, shape):
    cells = shape[0] * shape[1] * shape[2]
    return nn.Sequential(nn.Flatten(), nn.Linear(cells, classes))

TINY = NetSpec("tiny", "one matrix", build, GridSpec("rectangular", (8, 8, 8)), source="a test")
"""
PLANNER = """
from circumspect.planning import CirclePlanner, ViewPlanner

class Wide(CirclePlanner):
    def __init__(self):
        super().__init__(step_deg=60.0)

class Unfinished(ViewPlanner):
    pass
"""
READER = """
import numpy as np

def read_blob(path):
    return np.frombuffer(path.read_bytes(), "<f4").reshape(-1, 3)
"""
GROUPS = {
    "circumspect.nets": {"tiny": "spare_net:TINY"},
    "circumspect.planners": {"wide": "spare_planner:Wide"},
    "circumspect.readers": {"blob": "spare_reader:read_blob"},
}
MODULES = {"spare_net": NET, "spare_planner": PLANNER, "spare_reader": READER}


@pytest.fixture(autouse=True)
def _as_after_start():
    forget_plugins()
    yield
    forget_plugins()


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "site"
    folder.mkdir()
    install(folder, monkeypatch, MODULES, GROUPS)
    return folder


def numbers(value):
    return Registry("number", "circumspect.test", {"one": 1}, value)


def whole(name, value):
    if not isinstance(value, int):
        raise InputError("is no whole number")
    return value


def test_built_in_names_are_found_without_reading_package_metadata(monkeypatch):
    registry = numbers(whole)
    monkeypatch.setattr(registry, "_offered", pytest.fail)
    assert registry.get("one") == 1


def test_unknown_name_lists_built_in_ones_and_plugins(package):
    with pytest.raises(
        InputError, match=r"no view planner 'cirle'; known: normals, circle, conf.*"
    ):
        make_planner("cirle")
    with pytest.raises(InputError, match=r"wide; did you mean circle\?"):
        make_planner("circl")


def test_entry_points_of_all_kinds_are_loaded(package, tmp_path):
    assert make_planner("wide").step_deg == 60.0
    points = np.random.default_rng(0).random((50, 3)).astype("<f4")
    (tmp_path / "a.blob").write_bytes(points.tobytes())
    assert np.allclose(read_cloud(tmp_path / "a.blob").points_xyz, points)
    from circumspect.nets.registry import net_spec

    assert net_spec("tiny").source == "a test"


def test_reference_needs_no_package(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "loose_planner.py").write_text(PLANNER)
    assert make_planner("loose_planner:Wide").step_deg == 60.0
    assert PLANNER_REGISTRY.names() == tuple(PLANNERS)


@pytest.mark.parametrize(
    ("source", "cause"),
    [
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("1 / 0", r"ZeroDivisionError: division by zero \(.*broken\.py:1\)"),
        ("def broken(:", "SyntaxError"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("", "AttributeError: .* has no attribute 'Wide'"),
        ("Wide = 3", "is an object of the class int; a subclass of circumspect.planning.ViewPl"),
        ("Wide = object", "is the class object; a subclass"),
    ],
)
def test_a_broken_plugin_is_named_in_one_line(tmp_path, monkeypatch, source, cause):
    folder = tmp_path / "site"
    folder.mkdir()
    groups = {"circumspect.planners": {"wide": "broken:Wide"}}
    install(folder, monkeypatch, {"broken": source}, groups, name="broken-parts")
    with pytest.raises(PluginError, match=cause) as caught:
        make_planner("wide")
    message = str(caught.value)
    assert message.startswith("view planner 'wide' of broken-parts 1.2 ")
    assert "\n" not in message
    # Built-in planners are not affected.
    assert isinstance(make_planner("circle"), CirclePlanner)
    [plugin] = PLANNER_REGISTRY.plugins()
    assert plugin.error == message


def test_planner_that_can_not_be_made(package):
    with pytest.raises(PluginError, match="'spare_planner:Unfinished' can not be made: TypeError"):
        make_planner("spare_planner:Unfinished")


def test_plugin_of_a_built_in_name_does_not_replace_it(tmp_path, monkeypatch):
    folder = tmp_path / "site"
    folder.mkdir()
    groups = {"circumspect.planners": {"circle": "spare_planner:Wide"}}
    install(folder, monkeypatch, MODULES, groups)
    assert make_planner("circle") == CirclePlanner()
    [plugin] = PLANNER_REGISTRY.plugins()
    assert plugin.error is not None
    assert "name of a built-in one" in plugin.error


def test_one_name_of_two_packages_is_ambiguous(tmp_path, monkeypatch):
    for name in ("first", "second"):
        folder = tmp_path / name
        folder.mkdir()
        groups = {"circumspect.planners": {"wide": f"{name}_planner:Wide"}}
        install(folder, monkeypatch, {f"{name}_planner": PLANNER}, groups, name=name)
    with pytest.raises(PluginError, match=r"offered by second 1\.2 and first 1\.2; uninstall one"):
        make_planner("wide")


def test_reader_flag_reads_any_suffix(package, tmp_path, capsys):
    cloud = make_furniture("chair", 3).sampled(4000, 0).points_xyz
    (tmp_path / "chair.dat").write_bytes(cloud.astype("<f4").tobytes())
    file = str(tmp_path / "chair.dat")
    assert main(["classify", file, "--model", "modelnet10"]) == 2
    assert "unknown format '.dat'; known: .asc .blob .csv" in capsys.readouterr().err
    flags = ["--reader", "spare_reader:read_blob", "--model", "modelnet10", "--json"]
    assert main(["classify", file, *flags]) == 0
    assert json.loads(capsys.readouterr().out)["label"] == "chair"
    grid = str(tmp_path / "grid.npz")
    assert main(["grid", file, "--out", grid, "--reader", "spare_reader:read_blob"]) == 0


def test_file_name_is_no_reference_to_code(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "evil.py").write_text("open('evil ran', 'w')\ndef read(path): pass\n")
    file = tmp_path / "chair.evil:read"
    file.write_text("1 2 3")
    assert main(["classify", str(file)]) == 2
    assert "unknown format '.evil:read'" in capsys.readouterr().err
    assert not (tmp_path / "evil ran").exists()


def test_a_failing_reader_loses_only_its_file(package, tmp_path, capsys):
    (tmp_path / "odd.blob").write_bytes(b"12345")
    write_ply(tmp_path / "chair.ply", make_furniture("chair", 3).sampled(4000, 0))
    files = [str(tmp_path / name) for name in ("odd.blob", "chair.ply")]
    assert main(["classify", *files, "--json"]) == 2
    out, err = capsys.readouterr()
    assert "odd.blob: reader 'blob' fails: ValueError" in err
    assert len(out.splitlines()) == 1
    assert main(["classify", files[1], "--reader", "spare_reader:np"]) == 2
    assert (
        "an object of the class module; a function of a path is needed" in capsys.readouterr().err
    )


def test_reader_that_returns_something_else(tmp_path, monkeypatch):
    folder = tmp_path / "site"
    folder.mkdir()
    source = "def read(path):\n    return 'chair'\n"
    groups = {"circumspect.readers": {"blob": "wrong_reader:read"}}
    install(folder, monkeypatch, {"wrong_reader": source}, groups)
    (tmp_path / "a.blob").write_bytes(b"1")
    with pytest.raises(InputError, match="what it returns is an object of the class str; a Point"):
        read_cloud(tmp_path / "a.blob")
    assert READER_REGISTRY.names() == ("blob",)


def test_network_of_a_package_is_listed_with_its_distribution(package, capsys):
    assert main(["nets", "--json"]) == 0
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert records[-1]["name"] == "tiny"
    assert records[-1]["distribution"] == "spare-parts 1.2"
    assert records[0]["distribution"] is None
    assert main(["nets"]) == 0
    assert "one matrix (spare-parts 1.2)" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ('"tiny"', '"planes"', "has the name of the built-in network planes"),
        ('"tiny"', '"small"', "is named small by its NetSpec"),
        ('"tiny"', '"../up"', "has the name '../up'"),
        (
            "TINY = NetSpec",
            "TINY = dict() #",
            "object of the class dict; a circumspect.nets.NetSpec",
        ),
        ("return nn", "return str #", "what it builds is the class str; a torch Module"),
        ("cells, classes)", "cells, 7)", r"makes \(2, 7\), not scores of shape \(2, 10\)"),
        ("cells, classes)", "9, classes)", "can not be built or run: RuntimeError"),
    ],
)
def test_wrong_network_is_reported_and_the_others_are_listed(
    tmp_path, monkeypatch, capsys, old, new, cause
):
    folder = tmp_path / "site"
    folder.mkdir()
    groups = {"circumspect.nets": {"tiny": "wrong_net:TINY"}}
    install(folder, monkeypatch, {"wrong_net": NET.replace(old, new)}, groups)
    assert main(["nets", "--json"]) == 1
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 11
    assert re.search(cause, err)
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("training", "cause"),
    [
        ("{'epoch': 3}", "no training setting 'epoch'; known: augmentation, augmented"),
        ("{'epochs': 'three'}", "a training setting is of a wrong type"),
    ],
)
def test_wrong_training_settings_of_a_network_are_named(
    tmp_path, monkeypatch, capsys, training, cause
):
    folder = tmp_path / "site"
    folder.mkdir()
    source = NET.replace('source="a test"', f"training={training}")
    install(folder, monkeypatch, {"wrong_net": source}, {"circumspect.nets": {}})
    assert main(["train", "--net", "wrong_net:TINY", "--data", str(tmp_path)]) == 2
    assert cause in capsys.readouterr().err


def test_checkpoint_imports_no_code_of_its_choice(tmp_path, monkeypatch):
    from circumspect.errors import WeightsError
    from circumspect.nets import Checkpoint, build_net
    from circumspect.nets.registry import NETS

    monkeypatch.chdir(tmp_path)
    (tmp_path / "evil.py").write_text("open('evil ran', 'w')")
    weights = build_net("planes", 2, NETS["planes"].input_spec).state_dict()
    for name in ("evil:NET", "gone"):
        saved = Checkpoint(name, ("a", "b"), NETS["planes"].input_spec, weights)
        saved.save(tmp_path / "best.safetensors")
        with pytest.raises(WeightsError, match=f"'{name}', which is not installed; name its code"):
            Checkpoint.load(tmp_path / "best.safetensors")
    assert not (tmp_path / "evil ran").exists()


def test_doctor_lists_plugins(package, capsys):
    (package / "spare_reader.py").write_text("import nowhere")
    sys.modules.pop("spare_reader", None)
    assert main(["doctor", "--json"]) == 0, "a plug-in is nothing that every command needs"
    found = {entry["name"]: entry for entry in json.loads(capsys.readouterr().out)["plugins"]}
    assert set(found) == {"tiny", "wide", "blob"}
    assert found["tiny"]["distribution"] == "spare-parts 1.2"
    assert found["wide"]["error"] is None
    assert "No module named 'nowhere'" in found["blob"]["error"]
    main(["doctor"])
    out = capsys.readouterr().out
    assert "works   plug-in: view planner wide of spare-parts 1.2" in out
    assert "BROKEN  plug-in: reader 'blob' of spare-parts 1.2 can not be loaded" in out


def test_start_up_imports_no_metadata():
    code = (
        "import sys, circumspect.geometry.formats.cloud_files, circumspect.planning\n"
        "sys.exit('importlib.metadata' in sys.modules)"
    )
    loaded = (
        "import sys, numpy, scipy.spatial.transform; sys.exit('importlib.metadata' in sys.modules)"
    )
    before = subprocess.run([sys.executable, "-c", loaded], check=False).returncode
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == before


def test_scan_takes_planners_by_name(package):
    from circumspect.cli.commands.scan import Scan

    assert type(Scan("chair", planner="wide")._planner()).__name__ == "Wide"
    confident = Scan("chair", planner="wide", stop_when_sure=True)._planner()
    assert isinstance(confident, ConfidencePlanner)
    assert Scan("chair").planner == next(iter(PLANNERS))
