"""doctor lists what is installed, runs the checks, and gives the command for what is missing."""

import json
import re
from importlib import metadata

import numpy as np
import pytest

from circumspect.cli.commands import doctor as command
from circumspect.cli.main import main


def doctor(capsys, *flags):
    code = main(["doctor", *flags])
    return code, capsys.readouterr().out


def test_json_holds_packages_machine_and_checks(capsys):
    code, out = doctor(capsys, "--json")
    found = json.loads(out)
    assert code == 0
    assert found["extras"]["runtime"]["numpy"] == np.__version__
    assert found["cores"] >= 1
    assert [check["works"] for check in found["checks"]] == [True, True, True]
    assert found["cache"]["folder"].endswith("cache")


def test_every_extra_of_the_package_is_listed(capsys):
    extras = json.loads(doctor(capsys, "--json")[1])["extras"]
    declared = set(metadata.metadata("circumspect").get_all("Provides-Extra")) - {"all", "test"}
    assert declared | {"runtime"} == set(extras)
    assert all(extras.values()), "an extra without packages"


def test_an_incomplete_extra_comes_with_its_install_command(capsys, monkeypatch):
    real = command.version
    monkeypatch.setattr(command, "version", lambda n: None if n == "embreex" else real(n))
    code, out = doctor(capsys)
    assert code == 0, "the runtime is complete"
    assert 'get what sim lacks: pip install "circumspect[sim]"' in out
    assert re.search(r"^sim +missing", out, re.M)


def test_a_broken_runtime_sets_the_exit_code(capsys, monkeypatch):
    monkeypatch.setattr(command, "version", lambda name: None)
    assert doctor(capsys)[0] == 1


def test_a_kernel_with_wrong_counts_is_reported(capsys, monkeypatch):
    from circumspect.grid import CylindricalGrid, numpy_twin

    empty = CylindricalGrid().hits(np.zeros((1, 3)))
    monkeypatch.setattr(numpy_twin, "hits", lambda *arguments: empty)
    code, out = doctor(capsys)
    assert code == 1
    assert "BROKEN  native kernels: ArithmeticError" in out


def test_a_missing_library_is_reported_not_raised(monkeypatch):
    def missing():
        raise ImportError("libgomp.so.1: cannot open shared object file")

    monkeypatch.setattr(command, "_kernels", missing)
    assert not command.self_test()[0].works
    assert "libgomp" in command.self_test()[0].outcome


@pytest.mark.parametrize("columns", ["80", "40"])
def test_it_fits_the_terminal(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    lines = doctor(capsys)[1].splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("extra"))
    table = lines[start : lines.index("", start)]
    assert max(map(len, table)) <= int(columns)
