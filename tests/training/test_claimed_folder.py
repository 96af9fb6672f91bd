"""What a run's folder is good for: going on, and nothing that is there is lost."""

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

from circumspect.classification import GridRecipe, PointsRecipe
from circumspect.datasets import Augmentation
from circumspect.errors import CircumspectError, InputError, OutputError, WeightsError
from circumspect.nets.registry import net_spec
from circumspect.training import TrainingSettings
from circumspect.training.config_differences import MOST, config_differences
from circumspect.training.run_config import run_config

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
    recipe = GridRecipe(shape=(16, 32, 16))
    assert_refused(folder, InputError, r"grid\.shape \(\[32, 32, 32\], not \[1", recipe=recipe)


def forget(folder: Path, *names: str) -> dict:
    """Fields as a version that did not know them left them out."""
    config = json.loads((folder / CONFIG).read_text())
    for name in names:
        settings = config["settings"]
        settings.pop(name, None)
        settings["augmentation"].pop(name, None)
        config["grid"].pop(name, None)
    (folder / CONFIG).write_text(json.dumps(config))
    return config


def test_a_run_of_before_a_setting_was_there_goes_on(folder):
    forget(folder, "damage", "passes", "staggered")
    other = replace(QUICK, augmentation=Augmentation(damage=0.5))
    named = r"other settings\.augmentation\.damage \(0\.0, not 0\.5\);"
    assert_refused(folder, InputError, named, settings=other)
    assert run(folder).training["reached"]["epoch"] == 3
    # All of it is written, for readers of this version.
    written = json.loads((folder / CONFIG).read_text())
    assert written == run_config(QUICK, net_spec(QUICK.net).recipe, two_kinds().digest)


def test_a_run_of_before_there_was_a_margin_had_none(folder):
    forget(folder, "margin")
    assert_refused(folder, InputError, r"other grid\.margin \(1\.0, not 1\.1\);")


@given(st.sets(st.sampled_from(sorted(TrainingSettings().to_dict()))), st.booleans())
def test_any_setting_that_was_not_there_had_its_default(names, inner):
    asked = json.loads(json.dumps({"settings": TrainingSettings().to_dict(), "data": "x"}))
    stored = json.loads(json.dumps(asked))
    for name in names:
        del stored["settings"][name]
    if inner and "augmentation" not in names:
        del stored["settings"]["augmentation"]["partial"]
    assert config_differences(stored, asked) == ""


@pytest.mark.parametrize("recipe", [GridRecipe(margin=1.1), PointsRecipe(128)])
def test_recipes_of_before_grids_were_staggered_are_the_same(recipe):
    asked = {"settings": TrainingSettings().to_dict(), "grid": recipe.to_dict(), "data": "x"}
    asked = json.loads(json.dumps(asked))
    stored = json.loads(json.dumps(asked))
    stored["grid"].pop("staggered", None)
    assert config_differences(stored, asked) == ""


def test_differences_are_told_in_one_short_line():
    assert config_differences({"data": "a" * 64}, {"data": "b" * 64}) == "data"
    assert config_differences({"gone": 1, "one": {"x": 1}}, {"one": {}}) == "one, gone, one.x"
    many = {str(number): number for number in range(MOST + 3)}
    told = config_differences(many, dict.fromkeys(many, -1))
    assert told.startswith("0 (0, not -1), 1 (1")
    assert told.endswith("), 3 more")


@pytest.mark.parametrize("sign", ["made_of.json", BEST])
def test_a_finished_run_without_its_state_is_not_begun_anew(folder, sign):
    """As `reproduce` leaves it, and as one who frees space does."""
    run(folder)
    (folder / STATE).unlink()
    if sign == "made_of.json":
        (folder / BEST).unlink()
        shutil.copy(folder / CONFIG, folder / sign)
    assert_refused(
        folder,
        InputError,
        "holds a run's network without the state to go on from; choose another --out",
    )
    assert_refused(
        folder, InputError, "without the state to go on from", settings=replace(QUICK, epochs=1)
    )


@pytest.mark.parametrize("name", [STATE, BEST, "made_of.json", "epochs.csv"])
def test_what_only_has_the_name_of_a_result_is_not_replaced(tmp_path, name):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / name).write_text("mine")
    assert_refused(tmp_path / "run", OutputError, f"{name}: is of no such run and would be")


@pytest.mark.parametrize("text", ["{", "[]", "3", "{}", '{"settings": {}}', '{"object": "chair"}'])
def test_the_config_of_something_else_is_not_replaced(tmp_path, text):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / CONFIG).write_text(text)
    assert_refused(tmp_path / "run", OutputError, r"config\.json: is of no training and would be")


class Killer(Silent):
    """Ends a run within its first epoch."""

    def stepped(self, epoch, step, steps, loss):
        raise KeyboardInterrupt


def test_a_run_that_has_nothing_to_lose_is_begun_anew_with_other_settings(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "run", observer=Killer())
    assert (tmp_path / "run" / CONFIG).exists()
    other = replace(QUICK, seed=2)
    assert run(tmp_path / "run", other, stop_after=1).training["settings"]["seed"] == 2


def test_a_run_that_ended_before_its_first_state_was_there_is_begun_anew(tmp_path, monkeypatch):
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
        "without the state to go on from",
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
from circumspect.classification import GridRecipe
from circumspect.errors import OutputError
from circumspect.nets import Checkpoint, build_net
from circumspect.training.resume import save_state

net = build_net("planes", 2, GridRecipe())
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
folder = Path(sys.argv[1])
best = Checkpoint("planes", ("a", "b"), GridRecipe(), net.state_dict())
state = lambda path: save_state(path, {"net": net}, torch.optim.SGD(net.parameters()), {})
for name, save in (("best", best.save), ("state", state)):
    try:
        save(folder / f"{name}.safetensors")
    except OutputError as error:
        print(error)
"""


def test_a_full_disk_is_told_and_leaves_the_old_files(tmp_path):
    paths = [tmp_path / BEST, tmp_path / STATE]
    for path in paths:
        path.write_text("old")
    words = [sys.executable, "-c", FULL_DISK, str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    told = done.stdout.splitlines()
    assert told == [
        f"{path}: can not be written (file too large); free space or choose another place"
        for path in paths
    ]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        BEST: "old", STATE: "old"
    }  # fmt: skip
