"""What `locate track` and `locate simulate` may replace, and what not."""

from __future__ import annotations

from pathlib import Path

import pytest

from circumspect.cli.commands.simulated_space import SIMULATED
from circumspect.cli.commands.simulated_views import NAMES, SimulatedViews
from circumspect.cli.located_run import RESULTS, LocatedRun
from circumspect.errors import InputError, OutputError

SCAN = ("config.json", "log.jsonl", "result.json", "trajectory.txt", "space.jsonl", "space.png")
"""Of a scan with ceiling cameras."""


def filled(folder: Path, *names: str) -> Path:
    for name in names:
        (folder / name).write_text("mine")
    return folder


def contents(folder: Path) -> dict[str, str]:
    return {file.name: file.read_text() for file in folder.iterdir()}


@pytest.mark.parametrize("name", [name for name in RESULTS if name != "space.jsonl"])
def test_a_foreign_file_is_not_replaced(tmp_path: Path, name: str) -> None:
    before = contents(filled(tmp_path, name, "other.txt"))
    with pytest.raises(OutputError, match=f"{name}: is of no such run and would be replaced"):
        LocatedRun(tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("name", SIMULATED)
def test_a_simulation_does_not_replace_a_foreign_calibration(tmp_path: Path, name: str) -> None:
    """Not even where a track lies beside it."""
    filled(tmp_path, name, *RESULTS)
    LocatedRun(tmp_path)
    with pytest.raises(OutputError, match="is of no such run"):
        LocatedRun(tmp_path, SIMULATED)


def test_a_scan_with_ceiling_cameras_is_not_replaced(tmp_path: Path) -> None:
    before = contents(filled(tmp_path, *SCAN))
    with pytest.raises(OutputError, match=r"space\.jsonl: is of no such run"):
        LocatedRun(tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("more", [(), SIMULATED])
def test_an_earlier_run_of_its_kind_is_replaced(tmp_path: Path, more: tuple[str, ...]) -> None:
    LocatedRun(filled(tmp_path, "notes.txt"), more)
    LocatedRun(filled(tmp_path, "space.jsonl", "result.json", *more), more)


@pytest.mark.parametrize("name", NAMES)
def test_existing_image_names_are_not_replaced(tmp_path: Path, name: str) -> None:
    (tmp_path / name).symlink_to("gone")
    with pytest.raises(InputError, match=f"holds {name} already"):
        SimulatedViews(tmp_path)
