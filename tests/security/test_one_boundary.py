"""Whatever goes wrong with one file costs that file one line; the others are still processed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from circumspect.cli.main import main
from circumspect.errors import CircumspectError, naming_file
from circumspect.geometry import PointCloud


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (TypeError("a list\nis no number"), "TypeError: a list"),
        (RecursionError("too deep"), "RecursionError"),
        (MemoryError(), "does not fit into memory"),
        (PermissionError(13, "Permission denied"), "permission denied"),
        (CircumspectError("is empty"), r"^a\.ply: is empty$"),
        (CircumspectError("a.ply: is empty"), r"^a\.ply: is empty$"),
    ],
)
def test_any_error_becomes_an_input_error_that_names_the_file(
    error: Exception, message: str
) -> None:
    with pytest.raises(CircumspectError, match=message) as found, naming_file(Path("a.ply")):
        raise error
    assert str(found.value).startswith("a.ply: ")
    assert "\n" not in str(found.value)


@pytest.mark.parametrize("error", [BrokenPipeError(), KeyboardInterrupt()])
def test_errors_unrelated_to_a_file_pass_through(error: BaseException) -> None:
    with pytest.raises(type(error)), naming_file(Path("a.ply")):
        raise error


def test_a_faulty_reader_loses_only_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = np.random.default_rng(0).random((3000, 3))
    for name in ("a.npy", "b.npy", "c.npy"):
        np.save(tmp_path / name, points)

    def read(path: Path, **_: object) -> PointCloud:
        if path.name == "b.npy":
            raise AttributeError("'bool' object has no attribute 'bit_length'")
        return PointCloud(points)

    monkeypatch.setattr("circumspect.geometry.read_cloud", read)
    files = [str(tmp_path / name) for name in ("a.npy", "b.npy", "c.npy")]
    assert main(["classify", *files, "--json"]) == 2
    printed = capsys.readouterr()
    assert [json.loads(line)["file"] for line in printed.out.splitlines()] == [files[0], files[2]]
    assert printed.err.count("\n") == 1
    assert "b.npy: can not be used (AttributeError" in printed.err
