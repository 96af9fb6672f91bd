"""Rivals beside ours, end to end on a little furniture."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from experiment_watcher import Watched
from little_furniture import furniture
from matplotlib.image import imread
from network_inputs import trained_looking

from circumspect.datasets import GridCache
from circumspect.datasets.corruption import CORRUPTIONS
from circumspect.errors import InputError
from circumspect.evaluation.yaw_sweep import spread_yaws
from circumspect.export import export_onnx
from circumspect.nets import NETS, Checkpoint
from circumspect_experiments import Comparison, reproduce_rivals, reproduce_robustness, rivals
from circumspect_experiments.contenders import ALL_ROWS, RIVALS, Contender
from circumspect_experiments.rivals import WHOLE_DEG, _file_name, _in_onnx
from circumspect_experiments.stages import done_once

QUICK = Comparison(nets=("voxnet", "pointnet"), epochs=1, yaw_count=3)


def run(tmp_path, watched=None, comparison=QUICK):
    return reproduce_rivals(
        furniture(4, 0), furniture(1, 500), comparison, tmp_path / "out", watched or Watched(),
        GridCache(tmp_path / "grids"),
    )  # fmt: skip


def test_rivals_and_ours_in_one_table(tmp_path):
    out = tmp_path / "out"
    run(tmp_path, comparison=replace(QUICK, nets=("pointnet",)))
    # A network is added to what is there; the race is run again, since it is one of all.
    added = Watched()
    document = run(tmp_path, added)
    assert [step for step in added.steps if "any way up" in step] == ["voxnet, any way up"]
    assert list(document["nets"]) == ["circumspect", "voxnet", "pointnet"]
    for row in document["nets"].values():
        assert 0 <= row["worst"] <= row["mean"] <= 1
        assert row["spread"] >= 0
        assert row["milliseconds"] > 0
        assert {"at_0", "tumbled", "stood_up", "whole_cells", "whole_cells_flip_rate"} <= set(row)
    ours = document["nets"]["circumspect"]
    assert ours["mean"] > 0.6
    assert ours["whole_cells_flip_rate"] == 0
    assert ours["stood_up"] >= ours["tumbled"]
    assert "training" not in ours
    assert document["nets"]["pointnet"]["training"]["epochs"] == 1
    text = (out / "rivals.md").read_text()
    assert text.count("\n| ") == 9
    command = "circumspect reproduce rivals --data modelnet10 --nets voxnet pointnet --epochs 1"
    assert f"`{command} --yaw-count 3" in text
    assert np.ptp(imread(out / "rivals_over_yaw.png")[..., :3]) > 0.5
    check_robustness(out)
    again = Watched()
    assert run(tmp_path, again) == document
    assert not any("any way up" in step for step in again.steps)
    with pytest.raises(InputError, match="other settings"):
        run(tmp_path, comparison=Comparison(nets=("voxnet",), epochs=2, yaw_count=3))


def test_single_rows_are_run_and_the_table_holds_the_finished_ones(tmp_path):
    """Row by row: each command trains and measures its own row alone."""
    comparison = Comparison(nets=("voxnet", "voxnet-random-yaw", "pointmlp"), epochs=1, yaw_count=2)
    out = tmp_path / "out"
    first = run(tmp_path, comparison=replace(comparison, only=("voxnet",)))
    assert list(first["nets"]) == ["voxnet"]
    assert " rivals --data modelnet10 --nets voxnet --epochs 1 " in first["command"]
    text = (out / "rivals.md").read_text()
    assert text.startswith("# Networks on ModelNet10, trained at 0° alone\n")
    assert "random yaw" not in text

    watched = Watched()
    second = run(tmp_path, watched, replace(comparison, only=("voxnet-random-yaw",)))
    assert list(second["nets"]) == ["voxnet", "voxnet-random-yaw"]
    assert second["nets"]["voxnet"]["training"] == first["nets"]["voxnet"]["training"]
    assert {step.split(",")[0] for step in watched.steps} == {"voxnet", "voxnet-random-yaw"}
    assert "voxnet, any way up" not in watched.steps, "a finished row is not measured again"
    text = (out / "rivals.md").read_text()
    assert text.startswith(
        "# Networks on ModelNet10, trained at 0° unless the name says otherwise\n"
    )
    assert text.count("| voxnet, trained at random yaw | ") == 2
    assert "at 0°, 3° and 7° (trained at random yaw: at 0°, 123° and 247°)" in text
    config = json.loads((out / "voxnet-random-yaw" / "training" / "config.json").read_text())
    assert config["settings"]["random_yaw"] is True
    assert config["settings"]["net"] == "voxnet"
    assert np.ptp(imread(out / "rivals_over_yaw.png")[..., :3]) > 0.5

    # Trained, but not measured: this row is not shown until it is asked for.
    shutil.rmtree(out / "voxnet" / "around")
    third = run(tmp_path, comparison=replace(comparison, only=("voxnet-random-yaw",)))
    assert list(third["nets"]) == ["voxnet-random-yaw"]
    text = (out / "rivals.md").read_text()
    assert text.startswith("# Networks on ModelNet10, trained at random yaw\n")
    with pytest.raises(
        InputError, match=r"voxnet(-random-yaw)?/training: .* other settings\.epochs"
    ):
        run(tmp_path, comparison=replace(comparison, only=("voxnet",), epochs=2))


def test_networks_are_converted_once_and_again_where_the_file_is_gone(tmp_path, monkeypatch):
    calls, weights = [], tmp_path / "best.safetensors"

    def noted(members, path):
        calls.append(path.name)
        return export_onnx(members, path)

    monkeypatch.setattr(rivals, "export_onnx", noted)
    net = trained_looking("voxnet", classes=2)
    input_spec = NETS["voxnet"].input_spec
    Checkpoint("voxnet", ("plate", "post"), input_spec, net.state_dict()).save(weights)
    (tmp_path / "voxnet").mkdir()
    for _ in range(2):
        assert _in_onnx("voxnet", weights, tmp_path).classes == ("plate", "post")
    assert calls == ["net.onnx"]
    (tmp_path / "voxnet" / "net.onnx").unlink()
    assert _in_onnx("voxnet", weights, tmp_path).classes == ("plate", "post")
    assert len(calls) == 2


def check_robustness(out):
    """Networks that are there already are not trained again."""
    watched = Watched()
    comparison = replace(QUICK, nets=("voxnet",))
    document = reproduce_robustness(furniture(4, 0), furniture(1, 500), comparison, out, watched)
    assert watched.steps == ["circumspect, corrupted", "voxnet, corrupted"]
    ours = document["nets"]["circumspect"]
    assert set(ours["accuracy"]) == set(CORRUPTIONS)
    assert ours["mean"] < ours["clean"]
    assert all(len(row) == 5 and max(row) <= 1 for row in ours["accuracy"].values())
    text = (out / "robustness.md").read_text()
    assert text.count("\n| ") == 2 + 1 + len(CORRUPTIONS) + 1 + 1 + 1 + len(CORRUPTIONS)
    command = "circumspect reproduce robustness --data modelnet10 --nets voxnet --epochs 1"
    assert f"`{command} " in text
    # Only ours: the other row is there already.
    both = reproduce_robustness(
        furniture(4, 0),
        furniture(1, 500),
        replace(comparison, only=("circumspect",)),
        out,
        Watched(),
    )
    assert both == document
    # A corruption of a network is a stage of its own: an interruption costs one at most.
    corrupted = out / "voxnet" / "corrupted"
    kept = {kind: (corrupted / kind / "made_of.json").stat().st_mtime_ns for kind in CORRUPTIONS}
    shutil.rmtree(corrupted / "tilt")
    again = reproduce_robustness(furniture(4, 0), furniture(1, 500), comparison, out, Watched())
    assert again == document
    renewed = {
        kind
        for kind in CORRUPTIONS
        if (corrupted / kind / "made_of.json").stat().st_mtime_ns != kept[kind]
    }
    assert renewed == {"tilt"}


def test_whole_cells_are_whole_and_yaws_over_the_turn_are_not():
    cell = 360 / 32
    assert all(angle % cell == 0 for angle in WHOLE_DEG)
    # Nor are they whole quarters of a cell, the distance of a classifier's views.
    off = np.array(spread_yaws(64))[1:] % (cell / 4)
    assert np.minimum(off, cell / 4 - off).min() > 1e-3


def test_every_rival_has_a_source():
    assert set(RIVALS) <= set(ALL_ROWS)
    for name in {Contender.from_name(row).net for row in ALL_ROWS[1:]}:
        assert NETS[name].source[-4:].isdigit()
        assert NETS[name].departures
    assert Comparison().settings("moon2018").optimizer == "sgd"


def test_rows_at_random_yaw_are_beside_those_at_zero():
    rows = [Contender.from_name(name) for name in ALL_ROWS]
    assert [row.name for row in rows] == list(ALL_ROWS)
    turned = [row for row in rows if row.random_yaw]
    assert [row.net for row in turned] == ["voxnet", "3dshapenets", "pointnet", "pointmlp"]
    for row in turned:
        settings, plain = Comparison().settings(row.name), Comparison().settings(row.net)
        assert settings == replace(plain, random_yaw=True)
        assert row.label == f"{row.net}, trained at random yaw"
        assert rows.index(row) == rows.index(Contender(row.net)) + 1
    assert not any(Comparison().settings(row.name).random_yaw for row in rows if row not in turned)
    # Its objects are shown as they are, one variant of each, unless they are turned.
    assert Comparison(nets=("moon2018",)).settings("moon2018").replicas == 1
    comparison = Comparison(nets=("moon2018-random-yaw",))
    assert comparison.settings("moon2018-random-yaw").replicas == 24


@pytest.mark.parametrize(
    ("flags", "why"),
    [
        ({"nets": ("voxne-random-yaw",)}, "did you mean voxnet?"),
        ({"nets": ("headed-planes-random-yaw",)}, "headed-planes learns which way objects face"),
        ({"only": ("planes",)}, "--only planes: this comparison has circumspect, moon2018, voxnet"),
        ({"nets": ("voxnet",), "only": ("pointnet",)}, "this comparison has circumspect, voxnet$"),
        ({"nets": ("voxnet",), "epochs_of": {"voxnet-random-yaw": 2}}, "trains voxnet$"),
    ],
)
def test_rows_that_can_not_be_compared(flags, why):
    with pytest.raises(InputError, match=why):
        Comparison(**flags)


def test_the_command_of_a_part_of_a_table_makes_that_part():
    comparison = Comparison(
        only=("pointmlp",),
        epochs_of={"voxnet": 2, "pointmlp": 5},
        precision_of={"pointmlp-random-yaw": "bf16"},
    )
    assert (
        " --nets voxnet pointmlp --epochs voxnet=2 pointmlp=5 --yaw-count 64 "
        in comparison.of_rows(["pointmlp", "circumspect", "voxnet"]).command("rivals")
    )
    assert " rivals --only circumspect --yaw-count 64 " in comparison.of_rows([]).command("rivals")
    whole = comparison.of_rows(ALL_ROWS).command("rivals")
    assert "--nets" not in whole
    assert "--precision fp32 pointmlp-random-yaw=bf16 " in whole


def test_times_of_many_networks_have_a_folder():
    assert _file_name("circumspect+voxnet") == "circumspect+voxnet"
    assert len(_file_name("+".join(ALL_ROWS))) < 255
    assert len(_file_name("+".join([*ALL_ROWS, *ALL_ROWS]))) == 64


def test_epochs_of_all_and_of_one():
    comparison = Comparison(epochs=3, epochs_of={"moon2018": 2})
    assert comparison.settings("pointnet").epochs == 3
    assert comparison.settings("moon2018").epochs == 2
    assert " --epochs 3 moon2018=2 --yaw-count 64 " in comparison.command("rivals")
    assert Comparison(epochs_of={"moon2018": 2}).settings("pointnet").epochs == 30


def test_precision_of_all_and_of_one():
    comparison = Comparison(precision="bf16", precision_of={"moon2018": "fp32"})
    assert comparison.settings("pointnet").precision == "bf16"
    assert comparison.settings("moon2018").precision == "fp32"
    assert " --precision bf16 moon2018=fp32 --seed " in comparison.command("rivals")


def test_a_result_is_made_once(tmp_path):
    made = []
    for _ in range(2):
        found = done_once(
            tmp_path / "a", {"seed": 1}, lambda: made.append(1) or {"x": 2}, {"x": int}
        )
        assert found == {"x": 2}
    assert made == [1]
    with pytest.raises(InputError, match="other seed"):
        done_once(tmp_path / "a", {"seed": 2}, dict, {})
    (tmp_path / "a" / "result.json").unlink()
    with pytest.raises(InputError, match=r"result\.json"):
        done_once(tmp_path / "a", {"seed": 1}, dict, {})
