"""The folder of a run: it resumes, and no existing file is lost."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from quick_run import QUICK, Silent, run
from two_kinds import two_kinds

from circumspect.classification import GridSpec, PointsSpec
from circumspect.datasets import Augmentation
from circumspect.errors import CircumspectError, InputError, OutputError, WeightsError
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect.training.run_config import (
    MAX_DIFFERENCES,
    claim_folder,
    config_differences,
    run_config,
)

STATE, BEST, CONFIG = "state.safetensors", "best.safetensors", "config.json"


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("begun") / "run"
    run(folder, stop_after=1)
    return folder


@pytest.fixture
def folder(begun: Path, tmp_path: Path) -> Path:
    """A run of one epoch of three."""
    shutil.copytree(begun.parent / "grids", tmp_path / "grids")
    return Path(shutil.copytree(begun, tmp_path / "run"))


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def assert_refused(folder: Path, error: type[CircumspectError], match: str, **options) -> None:
    before = files_of(folder)
    with pytest.raises(error, match=match) as refused:
        run(folder, **options)
    assert "\n" not in str(refused.value)
    assert files_of(folder) == before


def test_other_settings_are_not_mixed_in(folder):
    other = replace(QUICK, epochs=4, augmentation=Augmentation(stretch=0.1))
    named = (
        r"other settings\.epochs \(3, not 4\), settings\.augmentation\.stretch \(0\.06, not 0\.1\);"
    )
    assert_refused(folder, InputError, named, settings=other)
    assert_refused(
        folder, InputError, "other data; choose another --out", objects=two_kinds(seed=5)
    )
    input_spec = GridSpec(shape=(16, 32, 16))
    assert_refused(
        folder, InputError, r"grid\.shape \(\[32, 32, 32\], not \[1", input_spec=input_spec
    )


def forget(folder: Path, *names: str) -> dict:
    """Remove fields, as a version without them wrote."""
    config = json.loads((folder / CONFIG).read_text())
    for name in names:
        settings = config["settings"]
        settings.pop(name, None)
        settings["augmentation"].pop(name, None)
        config["grid"].pop(name, None)
    (folder / CONFIG).write_text(json.dumps(config))
    return config


def test_an_older_run_without_a_setting_resumes(folder):
    forget(folder, "damage", "passes", "dithered")
    other = replace(QUICK, augmentation=Augmentation(damage=0.5))
    named = r"other settings\.augmentation\.damage \(0\.0, not 0\.5\);"
    assert_refused(folder, InputError, named, settings=other)
    assert run(folder).training["reached"]["epoch"] == 3
    # All of it is written, for readers of this version.
    written = json.loads((folder / CONFIG).read_text())
    assert written == run_config(QUICK, net_spec(QUICK.net).input_spec, two_kinds().digest)


def test_an_older_run_has_no_margin(folder):
    forget(folder, "margin")
    assert_refused(folder, InputError, r"other grid\.margin \(1\.0, not 1\.1\);")


@given(st.sets(st.sampled_from(sorted(TrainingSettings().to_dict()))), st.booleans())
def test_missing_settings_have_their_defaults(names, inner):
    asked = json.loads(json.dumps({"settings": TrainingSettings().to_dict(), "data": "x"}))
    stored = json.loads(json.dumps(asked))
    for name in names:
        del stored["settings"][name]
    if inner and "augmentation" not in names:
        del stored["settings"]["augmentation"]["partial"]
    assert config_differences(stored, asked) == ""


@pytest.mark.parametrize("input_spec", [GridSpec(margin=1.1), PointsSpec(128)])
def test_stored_input_specs_without_dithering_are_the_same(input_spec):
    asked = {"settings": TrainingSettings().to_dict(), "grid": input_spec.to_dict(), "data": "x"}
    asked = json.loads(json.dumps(asked))
    stored = json.loads(json.dumps(asked))
    stored["grid"].pop("dithered", None)
    assert config_differences(stored, asked) == ""


def test_config_with_the_earlier_name_of_dithered_is_the_same():
    input_spec = GridSpec(azimuth_views=8, margin=1.1, dithered=True)
    asked = {"settings": TrainingSettings().to_dict(), "grid": input_spec.to_dict(), "data": "x"}
    stored = json.loads(json.dumps(asked))
    stored["grid"]["staggered"] = stored["grid"].pop("dithered")
    assert config_differences(stored, json.loads(json.dumps(asked))) == ""


def test_differences_are_listed_in_one_short_line():
    assert config_differences({"data": "a" * 64}, {"data": "b" * 64}) == "data"
    assert config_differences({"gone": 1, "one": {"x": 1}}, {"one": {}}) == "one, gone, one.x"
    many = {str(number): number for number in range(MAX_DIFFERENCES + 3)}
    reported = config_differences(many, dict.fromkeys(many, -1))
    assert reported.startswith("0 (0, not -1), 1 (1")
    assert reported.endswith("), 3 more")


def test_only_the_writing_process_makes_the_folder_and_all_check_it(folder, tmp_path):
    """The first process would take temporary files of another for abandoned ones."""
    config = run_config(QUICK, net_spec(QUICK.net).input_spec, two_kinds().digest)
    claim_folder(tmp_path / "new", config, writes=False)
    assert not (tmp_path / "new").exists()
    with pytest.raises(InputError, match="other settings"):
        claim_folder(folder, {**config, "settings": {}}, writes=False)


@pytest.mark.parametrize("sign", ["made_of.json", BEST])
def test_a_finished_run_without_its_state_does_not_restart(folder, sign):
    """As `reproduce` leaves it, or a user who frees space."""
    run(folder)
    (folder / STATE).unlink()
    if sign == "made_of.json":
        (folder / BEST).unlink()
        shutil.copy(folder / CONFIG, folder / sign)
    assert_refused(
        folder,
        InputError,
        "holds a run's network without a state to resume from; choose another --out",
    )
    assert_refused(
        folder, InputError, "without a state to resume from", settings=replace(QUICK, epochs=1)
    )


@pytest.mark.parametrize("name", [STATE, BEST, "made_of.json", "epochs.csv"])
def test_a_foreign_file_with_the_name_of_a_result_is_not_replaced(tmp_path, name):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / name).write_text("mine")
    assert_refused(tmp_path / "run", OutputError, f"{name}: is of no such run and would be")


@pytest.mark.parametrize("text", ["{", "[]", "3", "{}", '{"settings": {}}', '{"object": "chair"}'])
def test_a_foreign_config_is_not_replaced(tmp_path, text):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / CONFIG).write_text(text)
    assert_refused(tmp_path / "run", OutputError, r"config\.json: is of no training and would be")


class Killer(Silent):
    """Ends a run within its first epoch."""

    def stepped(self, epoch, step, steps, loss):
        raise KeyboardInterrupt


def test_a_run_without_results_restarts_with_other_settings(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "run", observer=Killer())
    assert (tmp_path / "run" / CONFIG).exists()
    other = replace(QUICK, seed=2)
    assert run(tmp_path / "run", other, stop_after=1).training["settings"]["seed"] == 2


def test_a_run_that_ended_before_its_first_state_restarts(tmp_path, monkeypatch):
    """Its network is there already, and the same command must go on."""
    module = sys.modules[run.__globals__["train"].__module__]

    def full(*_):
        raise OutputError("no space left")

    with monkeypatch.context() as patch:
        patch.setattr(module, "save_state", full)
        with pytest.raises(OutputError, match="no space"):
            run(tmp_path / "run")
    assert (tmp_path / "run" / BEST).exists()
    assert_refused(
        tmp_path / "run",
        InputError,
        "without a state to resume from",
        settings=replace(QUICK, seed=2),
    )
    assert run(tmp_path / "run").training["reached"]["epoch"] == 3


def test_broken_state_is_named(folder):
    state = folder / STATE
    state.write_bytes(state.read_bytes()[:1000])
    with pytest.raises(WeightsError, match=r"state\.safetensors"):
        run(folder)


def test_files_have_the_permissions_of_any_new_file(tmp_path):
    mask = os.umask(0o027)
    try:
        run(tmp_path / "run", stop_after=1)
    finally:
        os.umask(mask)
    for path in (tmp_path / "run").glob("*.*"):
        assert stat.S_IMODE(path.stat().st_mode) == 0o640, path


FULL_DISK = """
import resource, signal, sys
from pathlib import Path
import torch
from circumspect.classification import GridSpec
from circumspect.errors import OutputError
from circumspect.nets import Checkpoint, build_net
from circumspect.training.resume import save_state

net = build_net("planes", 2, GridSpec())
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
folder = Path(sys.argv[1])
best = Checkpoint("planes", ("a", "b"), GridSpec(), net.state_dict())
state = lambda path: save_state(path, {"net": net}, torch.optim.SGD(net.parameters()), {})
for name, save in (("best", best.save), ("state", state)):
    try:
        save(folder / f"{name}.safetensors")
    except OutputError as error:
        print(error)
"""


def test_a_full_disk_is_reported_and_leaves_the_old_files(tmp_path):
    paths = [tmp_path / BEST, tmp_path / STATE]
    for path in paths:
        path.write_text("old")
    words = [sys.executable, "-c", FULL_DISK, str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    reported = done.stdout.splitlines()
    assert reported == [
        f"{path}: can not be written (file too large); free space or choose another place"
        for path in paths
    ]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        BEST: "old", STATE: "old"
    }  # fmt: skip
