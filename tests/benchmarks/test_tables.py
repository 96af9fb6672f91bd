"""The tables of benchmarks use only the records of the requested settings."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "benchmarks" / "results"
FACTS = "\n- processor: "


def committed(name: str) -> list[dict]:
    return [json.loads(line) for line in (RESULTS / name).read_text().splitlines()]


def tables(module: str, folder: Path, found: list[dict], *flags: str) -> str:
    """The table that a benchmark writes from existing records."""
    lines = "".join(json.dumps(record) + "\n" for record in found)
    (folder / f"{module}.jsonl").write_text(lines)
    words = [sys.executable, "-m", f"benchmarks.{module}", "--out", str(folder), *flags]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return (folder / f"{module}.md").read_text().split(FACTS)[0]


def of_another_setting(record: dict) -> dict:
    """The same scan with a frame every 3 s, and another outcome."""
    key = record["key"].rsplit("/", 2)[0] + "/3/4000"
    changed = {"key": key, "frame_interval": 3.0, "label": "lamp", "ate_rmse_m": 9.0}
    return {**record, **changed}


def test_the_faults_of_other_settings_are_left_out(tmp_path: Path) -> None:
    found = committed("faults.jsonl")
    mixed = [*map(of_another_setting, found[:5]), *found]
    wanted = (RESULTS / "faults.md").read_text().split(FACTS)[0]
    assert tables("faults", tmp_path, mixed, "--only", "none") == wanted


def test_a_table_of_other_settings_names_them(tmp_path: Path) -> None:
    found = committed("faults.jsonl")
    others = [of_another_setting(record) for record in found if record["fault"] == "none"]
    text = tables("faults", tmp_path, [*found, *others], "--only", "none", "--frame-interval", "3")
    assert "`python -m benchmarks.faults --frame-interval 3`" in text
    (row,) = [line for line in text.splitlines() if line.startswith("| none |")]
    assert row.startswith("| none | 0 of 3 |")
    assert "| 9000 |" in row
    assert "blackout" not in text


@pytest.mark.parametrize("mixed", [False, True])
def test_the_scans_of_other_settings_are_left_out(tmp_path: Path, mixed: bool) -> None:
    """Except for the answers on ModelNet10, which need its data."""
    found = [record for record in committed("scans.jsonl") if record["suite"] != "modelnet"]
    others = [of_another_setting(r) for r in found if r["suite"] == "planners"] if mixed else []
    text = tables("scans", tmp_path, [*others, *found], "--tables")
    sections = (RESULTS / "scans.md").read_text().split(FACTS)[0].split("\n## ")
    wanted = [section for section in sections if not section.startswith("Answers on ModelNet10")]
    assert text == "\n## ".join(wanted)


def test_the_time_of_the_slowest_frame_is_in_the_table(tmp_path: Path) -> None:
    found = [record for record in committed("scans.jsonl") if record["suite"] == "timing"]
    slowest = max(max(record["stages"]["frame"]) for record in found)
    (row,) = [
        line
        for line in tables("scans", tmp_path, found, "--tables").splitlines()
        if line.startswith("| frame |")
    ]
    assert row.endswith(f"| {slowest:.1f} |")


def test_all_furniture_is_summarised_on_one_line(tmp_path: Path) -> None:
    some = [r for r in committed("scans.jsonl") if r["suite"] == "furniture"][:2]
    errors = {"ate_rmse_m": 0.003, "ate_odometry_rmse_m": 0.1, "yaw_rmse_deg": 0.6}
    shape = {"chamfer_m": 0.005, "completeness": 0.95}
    worse = {**errors, "ate_rmse_m": 0.011, "chamfer_m": 0.007, "yaw_rmse_deg": 0.2}
    found = [{**some[0], **errors, **shape}, {**some[1], **shape, **worse}]
    text = tables("scans", tmp_path, found, "--tables")
    (line,) = [line for line in text.splitlines() if line.startswith("All 2 together")]
    # √((3² + 11²) / 2) and √((0.6² + 0.2²) / 2)
    assert "ATE 8.1 mm, 0.45°, odometry 100 mm" in line
    assert "the ratio is 0.081; chamfer 6.0 mm, completeness 0.950" in line
    assert line.endswith("1 (ATE), 1 (yaw), 2 (ratio), 1 (chamfer) and 2 (completeness).")
