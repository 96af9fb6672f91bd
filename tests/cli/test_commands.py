import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import circumspect
from circumspect.classification import SHIPPED, Classifier
from circumspect.cli.commands.grid import Grid
from circumspect.cli.main import COMMANDS, main
from circumspect.furniture import make_furniture
from circumspect.geometry import write_ply
from circumspect.grid import OccupancyGrid


def run(*words):
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def chair(tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "chair.ply"
    write_ply(path, make_furniture("chair", 3).sampled(20_000, 0))
    return path


class TestClassify:
    def test_json_is_one_object_a_line_and_nothing_else(self, chair, tmp_path, capsys):
        np.save(tmp_path / "chair.npy", make_furniture("chair", 3).sampled(2000, 0).points_xyz)
        assert run("classify", chair, tmp_path / "chair.npy", "--json") == 0
        out, err = capsys.readouterr()
        records = [json.loads(line) for line in out.splitlines()]
        assert [r["label"] for r in records] == ["chair", "chair"]
        for record in records:
            assert list(record) == [
                "file", "label", "confident", "reason", "in_distribution",
                "in_distribution_probability", "distance", "coverage", "probability",
                "probabilities", "alternatives", "points", "milliseconds",
            ]  # fmt: skip
            assert set(record["milliseconds"]) == {"load", "grid", "classify"}
        assert records[0]["points"] == 20_000
        assert err == ""

    def test_up_axis(self, tmp_path, capsys):
        points = make_furniture("chair", 3).sampled(20_000, 0).points_xyz
        np.save(tmp_path / "y.npy", points[:, [0, 2, 1]] * [1, 1, -1])
        assert run("classify", tmp_path / "y.npy", "--up", "y") == 0
        assert "chair" in capsys.readouterr().out.split(",")[0]

    def test_a_bad_file_does_not_stop_the_others(self, chair, tmp_path, capsys):
        (tmp_path / "empty.off").write_bytes(b"")
        np.save(tmp_path / "line.npy", np.linspace(0, 1, 40)[:, None] * [1.0, 2, 3])
        os.mkfifo(tmp_path / "pipe.npz")  # No process writes into the pipe.
        bad = [tmp_path / name for name in ("empty.off", "line.npy", "", "gone.ply", "pipe.npz")]
        assert run("classify", bad[0], chair, *bad[1:]) == 2
        out, err = capsys.readouterr()
        assert len(out.splitlines()) == 1
        assert out.startswith(str(chair))
        lines = err.splitlines()
        assert len(lines) == len(bad)
        for file, line in zip(bad, lines, strict=True):
            assert line.startswith("circumspect: ")
            assert str(file) in line

    def test_no_file_and_names_that_no_system_takes(self, capsys):
        assert run("classify") == 2
        assert "at least one file" in capsys.readouterr().err
        assert run("classify", "x" * 300 + ".ply") == 2
        assert run("evaluate", "--data", "y" * 300, "--yaw", "0") == 2
        assert run("classify", "a.ply", "--model", "z" * 300) == 2
        assert capsys.readouterr().err.count("\n") == 3

    @pytest.mark.parametrize("top", [0, -2])
    def test_fewer_than_one_class_is_refused(self, chair, capsys, top):
        assert run("classify", chair, "--top", top) == 2
        assert capsys.readouterr() == ("", f"circumspect: --top {top}: give 1 or more\n")
        assert run("classify", chair, "--top", 1) == 0
        assert capsys.readouterr().out.count("%") == 1

    def test_wrong_weights(self, chair, tmp_path, capsys):
        (tmp_path / "w.onnx").write_bytes(b"no")
        assert run("classify", chair, "--model", tmp_path / "w.onnx") == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1


class TestGrid:
    def test_saves_draws_and_the_grid_is_classified(self, chair, tmp_path, capsys):
        out = tmp_path / "g.npz"
        assert run("grid", chair, "--out", out) == 0
        assert out.with_suffix(".png").stat().st_size > 10_000
        assert run("classify", out, "--json") == 0
        record = json.loads(capsys.readouterr().out.splitlines()[-1])
        assert record["label"] == "chair"

    def test_has_the_margin_that_the_shipped_classifiers_expect(self, chair, tmp_path):
        out = tmp_path / "g.npz"
        assert {Grid.margin} == {Classifier.load(name).input_spec.margin for name in SHIPPED}
        radii = {}
        for flags in ((), ("--margin", 1.1), ("--margin", 1)):
            assert run("grid", chair, "--out", out, *flags) == 0
            radii[flags] = OccupancyGrid.load(out).grid.radius
        assert radii[()] == radii["--margin", 1.1]
        assert radii[()] == pytest.approx(1.1 * radii["--margin", 1])

    def test_a_margin_that_cuts_the_object_off_is_refused(self, chair, tmp_path, capsys):
        assert run("grid", chair, "--out", tmp_path / "g.npz", "--margin", 0.5) == 2
        assert "margin must be a number from 1 to 4" in capsys.readouterr().err

    def test_only_npz_names_are_taken(self, chair, tmp_path, capsys):
        assert run("grid", chair, "--out", tmp_path / "g.png") == 2
        assert "ends in .npz" in capsys.readouterr().err
        assert list(tmp_path.iterdir()) == []

    def test_a_turn_that_is_not_finite_writes_nothing(self, chair, tmp_path, capsys):
        assert run("grid", chair, "--out", tmp_path / "g.npz", "--turn", 0, "nan") == 2
        assert "--turn 0 nan: give degrees" in capsys.readouterr().err
        assert list(tmp_path.iterdir()) == []

    def test_a_grid_is_not_gridded_again(self, chair, tmp_path, capsys):
        assert run("grid", chair, "--out", tmp_path / "g.npz") == 0
        assert run("grid", tmp_path / "g.npz", "--out", tmp_path / "h.npz") == 2
        assert "g.npz: is a grid already; give what it was made of" in capsys.readouterr().err

    @pytest.mark.parametrize("up", ["x", "y", "auto"])
    def test_a_grid_is_not_turned_and_the_other_files_are_named(self, chair, tmp_path, capsys, up):
        out = tmp_path / "g.npz"
        run("grid", chair, "--out", out)
        capsys.readouterr()
        assert run("classify", out, chair, "--up", up, "--samples", 2000) == 2
        printed, fault = capsys.readouterr()
        assert printed.startswith(f"{chair}: ")
        assert fault == (
            f"circumspect: {out}: is a grid, which has its axis already; leave --up {up} out\n"
        )
        assert run("classify", out, "--up", "z") == 0

    def test_a_broken_grid_is_named(self, chair, tmp_path, capsys):
        out = tmp_path / "g.npz"
        run("grid", chair, "--out", out)
        capsys.readouterr()
        out.write_bytes(out.read_bytes()[:200])
        assert run("classify", out) == 2
        assert "g.npz" in capsys.readouterr().err


def test_nets_lists_parameters_and_multiply_adds(capsys):
    assert run("nets", "--json") == 0
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    ours = next(r for r in records if r["name"] == "planes")
    assert ours["parameters"] <= 2_000_000
    assert {"name", "parameters", "multiply_adds", "input"} <= set(ours)
    assert all(r["departures"] for r in records if r["source"] != "ours")
    assert run("nets") == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    printed = " ".join(" ".join(lines).split())
    for record in records:
        assert f"{record['name']}: {record['departures']}." in printed or not record["departures"]


def test_unknown_commands_get_a_suggestion(capsys):
    assert run("clasify") == 2
    assert "did you mean classify?" in capsys.readouterr().err
    with pytest.raises(SystemExit) as stop:
        run("classify", "--uq", "y")
    assert stop.value.code == 2


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself(name, capsys):
    with pytest.raises(SystemExit) as stop:
        run(name, "--help")
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert f"circumspect {name}" in out
    # The parser's own usage line is as long as it is.
    assert max(map(len, out.splitlines()[1:])) <= 80


def test_help_and_version(capsys):
    assert run("--help") == 0
    out = capsys.readouterr().out
    assert all(name in out for name in COMMANDS)
    assert max(map(len, out.splitlines())) <= 80
    assert run("--version") == 0
    assert capsys.readouterr().out == f"circumspect {circumspect.__version__}\n"


def test_ctrl_c_while_a_package_loads_does_not_say_that_it_is_missing(monkeypatch, capsys):
    def interrupted(name):
        raise ImportError("initialization failed") from KeyboardInterrupt()

    monkeypatch.setattr("circumspect.simulation.robot_physics.import_module", interrupted)
    assert run("scan", "chair", "--frames", 1) == 130
    assert "not installed" not in capsys.readouterr().err


class TestProcess:
    """Behaviour that needs a process of its own."""

    def test_classify_loads_neither_torch_nor_matplotlib(self, chair):
        code = (
            "import sys; from circumspect.cli.main import main\n"
            f"main(['classify', {str(chair)!r}])\n"
            "heavy = {'torch', 'matplotlib', 'onnx', 'embreex'} & set(sys.modules)\n"
            "sys.exit(f'loaded {heavy}' if heavy else 0)"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    def test_help_loads_no_heavy_packages(self):
        code = (
            "import sys; from circumspect.cli.main import main\n"
            "main(['--help'])\n"
            "heavy = {'numpy', 'scipy', 'trimesh', 'torch', 'onnxruntime'} & set(sys.modules)\n"
            "sys.exit(f'loaded {heavy}' if heavy else 0)"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    @pytest.mark.parametrize("encoding", ["utf-8:strict", "latin-1", "ascii"])
    def test_names_that_the_terminal_can_not_show(self, tmp_path, encoding):
        """Bytes that are no text, characters of another alphabet, and control sequences."""
        points = make_furniture("chair", 3).sampled(2000, 0).points_xyz
        names = (b"a_\xff.npy", "椅子.npy".encode(), b"c\x1b[2J\n.npy", b"gone_\xff.npy")
        files = [tmp_path / os.fsdecode(name) for name in names]
        for file in files[:3]:
            try:
                np.save(file, points)
            except OSError:
                pytest.skip("this file system takes text alone")
        words = [sys.executable, "-m", "circumspect", "classify", *map(str, files)]
        environment = {**os.environ, "PYTHONIOENCODING": encoding}
        done = subprocess.run(words, capture_output=True, env=environment)
        assert done.returncode == 2
        lines = done.stdout.splitlines()
        assert [b": chair " in line for line in lines] == [True] * 3
        assert rb"a_\udcff.npy" in lines[0]
        assert rb"c\x1b[2J\n.npy" in lines[2]
        assert b"Traceback" not in done.stderr
        assert rb"gone_\udcff.npy: " in done.stderr

    def test_a_full_disk_behind_standard_output(self, chair):
        words = [sys.executable, "-m", "circumspect", "classify", str(chair)]
        with Path("/dev/full").open("w") as full:
            done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 2
        assert done.stderr == "circumspect: standard output: no space left on device\n"

    def test_a_closed_pipe_is_no_error(self, chair):
        words = [sys.executable, "-m", "circumspect", "classify", str(chair), str(chair)]
        read, write = os.pipe()
        os.close(read)
        done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, text=True)
        os.close(write)
        assert done.returncode == 0
        assert "Traceback" not in done.stderr

    @pytest.mark.parametrize("command", ["doctor", "nets"])
    def test_a_pipe_closed_within_a_table_is_no_error(self, command):
        words = [sys.executable, "-m", "circumspect", command]
        read, write = os.pipe()
        os.close(read)
        done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, text=True)
        os.close(write)
        assert done.returncode == 0
        assert done.stderr == ""

    @pytest.mark.parametrize(("file", "code"), [("chair", 0), ("gone.ply", 2)])
    @pytest.mark.parametrize("closed", [(1,), (2,), (0, 1, 2)])
    def test_streams_may_be_closed(self, chair, tmp_path, file, code, closed):
        """A job started with `>&-` has closed streams; output that can not be written is an error."""
        file = chair if file == "chair" else tmp_path / file
        closing = " ".join(f"{number}>&-" for number in closed)
        call = f'"$@" {closing}'
        words = [sys.executable, "-m", "circumspect", "classify", str(file)]
        done = subprocess.run(["sh", "-c", call, "sh", *words], capture_output=True, text=True)
        assert done.returncode == (2 if 1 in closed else code)
        assert "Traceback" not in done.stderr
        if closed == (1,):
            reason = "standard output is closed" if code == 0 else "gone.ply"
            assert re.fullmatch(f"circumspect: .*{reason}.*\n", done.stderr)
        assert ("chair" in done.stdout) == (code == 0 and 1 not in closed)
        assert "circumspect: " not in done.stdout

    def test_commands_finish_without_standard_output(self, chair, tmp_path):
        words = [sys.executable, "-m", "circumspect", "grid", str(chair), "--out", "here.npz"]
        call = ["sh", "-c", '"$@" >&-', "sh", *words]
        done = subprocess.run(call, capture_output=True, text=True, cwd=tmp_path)
        assert (tmp_path / "here.npz").is_file()
        assert done.returncode == 2


def test_too_little_memory_is_reported_on_one_line(monkeypatch, capsys):
    def short(_):
        return np.empty((2**25, 2**20))

    monkeypatch.setattr("circumspect.cli.main._dispatch", short)
    assert main(["nets"]) == 2
    stderr = capsys.readouterr().err
    assert stderr.startswith("circumspect: not enough memory (Unable to allocate")
    assert stderr.count("\n") == 1


@pytest.mark.parametrize("classes", ["0", "100001", "100000000000"])
def test_nets_refuses_zero_or_too_many_classes(capsys, classes):
    assert main(["nets", "--classes", classes]) == 2
    assert capsys.readouterr().err == f"circumspect: --classes {classes}: give 1 to 100000\n"
