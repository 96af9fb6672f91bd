"""`circumspect scan --space`: ceiling cameras over a scan."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from circumspect.cli.commands.scan import Scan
from circumspect.cli.main import main
from circumspect.exploration import ScanSettings
from circumspect.geometry import read_tum


def track(*words):
    return main(["locate", "track", *map(str, words)])


def test_a_scan_is_compared_with_the_intelligent_space(tmp_path, capsys):
    out = tmp_path / "run"
    scan = Scan(
        object="chair-3",
        start=40.0,
        seed=5,
        driving=ScanSettings(frame_interval=2.0, max_frames=4),
        space=True,
    )
    bag = tmp_path / "run.mcap"
    assert replace(scan, out=out, record=bag, json=True).run() == 0
    record = json.loads(capsys.readouterr().out)
    assert record["ate_space_rmse_m"] == pytest.approx(record["ate_rmse_m"], abs=2e-3)
    assert 0 < record["space_error_m"] < 2e-3
    assert record["space_true_error_m"] < 3e-3
    measured = json.loads((out / "scan.json").read_text())["measured"]
    assert measured["ate_space_rmse_m"] == record["ate_space_rmse_m"]
    assert (out / "space.png").stat().st_size > 10_000
    assert len(read_tum(out / "space.txt")) == 4
    sigma = [
        json.loads(line)["position_sigma_m"]
        for line in (out / "space.jsonl").read_text().splitlines()
    ]
    assert np.median(sigma) == pytest.approx(record["space_error_m"], rel=0.5)
    # The ceiling cameras' images are in the recording; tracking through them is the same again.
    words = ("--calibration", out / "calibration.json", "--tag", 0, 0.2, 0.3)
    assert track(bag, *words, "--out", tmp_path / "again", "--json") == 0
    assert json.loads(capsys.readouterr().out)["images"] == 16
    again, live = read_tum(tmp_path / "again" / "trajectory.txt"), read_tum(out / "space.txt")
    difference = again.T_map_camera.translation - live.T_map_camera.translation
    assert np.abs(difference).max() < 1e-6
    assert track(bag, *words, "--topic", "ceiling_9=/x", "--json") == 2
    assert "no place of camera 'ceiling_9'" in capsys.readouterr().err
    assert track(out, *words, "--topic", "ceiling_0=/x", "--json") == 2
    assert "is not a bag" in capsys.readouterr().err


@pytest.mark.parametrize("frame", [1, 3])
def test_ctrl_c_keeps_calibration_and_recording_of_the_ceiling_cameras(
    tmp_path, ctrl_c_at, capsys, frame
):
    """Tracking through the recording needs the calibration."""
    out, bag = tmp_path / "run", tmp_path / "run.mcap"
    scan = Scan(
        object="chair-3",
        start=40.0,
        seed=5,
        driving=ScanSettings(frame_interval=2.0, max_frames=9),
        space=True,
    )
    ctrl_c_at(frame)
    with pytest.raises(KeyboardInterrupt):
        replace(scan, out=out, record=bag).run()
    assert len(read_tum(out / "space.txt")) == frame
    assert len((out / "space.jsonl").read_text().splitlines()) == frame
    assert (out / "space.png").stat().st_size > 10_000
    capsys.readouterr()
    words = ("--calibration", out / "calibration.json", "--tag", 0, 0.2, 0.3)
    assert track(bag, *words, "--out", tmp_path / "again", "--json") == 0
    assert json.loads(capsys.readouterr().out)["images"] == 4 * frame
