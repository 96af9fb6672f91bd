"""`--config FILE`: flags in a file, and the file that a run leaves."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Literal

import pytest
import tyro

from circumspect.cli.config_file import (
    CONFIG,
    ConfigFlag,
    config_text,
    early_value,
    read_config,
    write_config,
)
from circumspect.cli.flag_table import Flags, flags_of
from circumspect.cli.flags import parse
from circumspect.cli.main import main, parsed
from circumspect.errors import InputError, OutputError

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Stove:
    """How it is heated.

    Attributes:
        watts: Of the plate.
        gas: Burn gas.
        plate_cm: Across [cm].
        secret: No flag.
    """

    watts: float = 1500.0
    gas: bool = False
    plate_cm: int = 18
    secret: int = 7

    def __post_init__(self) -> None:
        if self.watts < 0:
            raise InputError(f"power is positive, not {self.watts}")


@dataclass(frozen=True)
class Cook:
    """Make soup.

    $ cook leek
    """

    what: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SOUP")]
    """Which soup."""
    salt: float | None = None
    """Grams."""
    pot: Path | None = None
    """Where."""
    heat: Literal["low", "high"] = "low"
    """How."""
    box: tuple[float, float] | None = None
    """Two numbers."""
    spices: tuple[str, ...] = ("pepper",)
    """Which."""
    lid: bool = field(default=True, metadata={"off": "Leave the lid off."})
    """Put the lid on."""
    bowls: int = 2
    """How many."""
    from_: str = "garden"
    """Where the leek is from."""
    stove: Annotated[Stove, Flags("watts", "gas", plate_cm="plate")] = field(
        default_factory=lambda: Stove(watts=900.0, secret=8)
    )
    """The stove."""
    config: ConfigFlag = None


def cooked(path: Path, text: str, *words: str) -> Cook:
    path.write_text(text)
    return parse(Cook, "cook", words, {Cook: read_config(path, Cook)})


def refused(path: Path, text: str) -> str:
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_config(path, Cook)
    return str(caught.value)


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    return tmp_path / "soup.toml"


def test_flags_of_settings_are_flags_of_the_command() -> None:
    assert parse(Cook, "cook", ["leek"]) == Cook("leek")
    cook = parse(Cook, "cook", ["leek", "--plate", "20", "--gas", "--watts", "5", "--from", "a"])
    assert cook == Cook("leek", from_="a", stove=Stove(5.0, True, 20, secret=8))
    assert list(flags_of(Cook))[-4:] == ["watts", "gas", "plate", "config"]


def test_settings_that_refuse_a_value_name_its_flag() -> None:
    with pytest.raises(InputError, match=r"^--watts: power is positive, not -3\.0$"):
        parse(Cook, "cook", ["leek", "--watts", "-3"])


def test_values_of_a_file_stand_where_no_flag_is_given(toml: Path) -> None:
    text = 'what = "pea"\nsalt = 2\nbox = [1, 2.5]\nfrom = "shop"\nplate = 30\nlid = false\n'
    wanted = Cook(
        "pea", 2.0, box=(1.0, 2.5), from_="shop", lid=False, stove=Stove(900, plate_cm=30, secret=8)
    )
    assert cooked(toml, text) == wanted
    assert isinstance(cooked(toml, text).salt, float)


def test_flags_win_over_the_file(toml: Path) -> None:
    text = 'what = "pea"\nheat = "high"\nspices = ["salt"]\nlid = false\ngas = true\n'
    words = ("leek", "--heat", "low", "--spices", "thyme", "dill", "--lid", "--no-gas")
    assert cooked(toml, text, *words) == Cook("leek", spices=("thyme", "dill"))


def test_dashes_tables_and_flags_that_switch_off(toml: Path) -> None:
    text = 'no-lid = true\nwhat = "pea"\n[stove]\nplate = 30\n'
    cook = cooked(toml, text)
    assert (cook.lid, cook.stove.plate_cm) == (False, 30)


def test_yaml(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    text = "what: pea\nsalt: null\npot: a/b\nstove: {watts: 3, gas: true}\n"
    wanted = Cook("pea", pot=Path("a/b"), stove=Stove(3.0, True, secret=8))
    assert cooked(tmp_path / "soup.yaml", text) == wanted
    assert cooked(tmp_path / "soup.yml", "", "leek") == Cook("leek")


def test_yaml_without_its_package(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "yaml", None)
    path = tmp_path / "node.yaml"
    path.write_text("rate: 3\n")
    assert main(["ros2", "--config", str(path)]) == 2
    assert 'PyYAML is not installed; get it with: pip install "' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("sallt = 1", "no key 'sallt'; did you mean salt?"),
        ("zzz = 1", "no key 'zzz'; known: what, salt, "),
        ("secret = 1", "no key 'secret'"),
        ("no_salt = true", "no key 'no_salt'"),
        ("config = 'x'", "no key 'config'"),
        ("[stove]\nsalt = 1", "no key 'salt' in [stove]; known: watts, gas, plate"),
        ("[pan]\nsalt = 1", "no key 'pan'"),
        ("lid = true\nno-lid = true", "lid is given twice"),
        ("salt = 'much'", "salt is a number, not 'much'"),
        ("salt = true", "salt is a number, not True"),
        ("bowls = 1.5", "bowls is a whole number, not 1.5"),
        ("lid = 1", "lid is true or false, not 1"),
        ("heat = 'mild'", "heat is one of low, high, not 'mild'"),
        ("box = [1]", "box is a list of 2, not [1]"),
        ("box = [1, 'a']", "box is a list, each of it a number, not [1, 'a']"),
        ("spices = 'dill'", "spices is a list, not 'dill'"),
        ("what = 1979-05-27", "what is a text, not 1979-05-27"),
        ("what = ", "is no TOML (Invalid value (at"),
        ("what = 'a'\nwhat = 'b'", "is no TOML ("),
        ("salt = " + "[" * 10_000, "is no TOML ("),
        ("#" * 2**21, "has more than 1048576 bytes"),
    ],
)
def test_a_wrong_file_is_one_line_that_names_file_and_key(
    toml: Path, text: str, fault: str
) -> None:
    error = refused(toml, text)
    assert error.startswith(f"{toml}: {fault}")
    assert "\n" not in error


@pytest.mark.parametrize(
    ("write", "fault"),
    [
        (lambda path: None, "no such file"),
        (lambda path: path.mkdir(), "is no file"),
        (lambda path: path.write_bytes(b"what = '\xff'"), "is no text"),
    ],
)
def test_a_file_that_can_not_be_read(toml: Path, write, fault: str) -> None:
    write(toml)
    with pytest.raises(InputError, match=f"{toml}: ") as caught:
        read_config(toml, Cook)
    assert fault in str(caught.value)


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ((), None),
        (("--config", "a"), "a"),
        (("--config=a", "b"), "a"),
        (("--config", "a", "--config", "b"), "b"),
        (("x", "--config"), None),
        (("--", "--config", "a"), None),
        (("--configs", "a"), None),
    ],
)
def test_early_value(words: tuple[str, ...], value: str | None) -> None:
    assert early_value(words, "config") == value


@pytest.mark.parametrize(
    "cook",
    [
        Cook("leek"),
        Cook(
            'a "b"\\ \n\x7f椅',
            -1e-9,
            Path("c d/e"),
            "high",
            (float("inf"), 1e300),
            (),
            False,
            10**18,
            "'",
            Stove(0.1, True, 3, secret=8),
        ),
    ],
)
def test_a_written_config_is_read_back(tmp_path: Path, cook: Cook) -> None:
    write_config(tmp_path, cook, "cook")
    assert parse(Cook, "cook", [], {Cook: read_config(tmp_path / CONFIG, Cook)}) == cook


def test_drawn_values_are_written(tmp_path: Path) -> None:
    write_config(tmp_path, Cook("leek"), "cook", salt=3.5)
    assert read_config(tmp_path / CONFIG, Cook)["salt"] == 3.5


def test_a_path_that_is_no_text_is_left_out(toml: Path) -> None:
    toml.write_text(config_text(Cook("leek", pot=Path("a_\udcff")), "cook"))
    assert "pot" not in read_config(toml, Cook)


def test_only_files_of_runs_are_replaced(tmp_path: Path) -> None:
    write_config(tmp_path, Cook("leek"), "cook")
    write_config(tmp_path, Cook("pea"), "cook")
    (tmp_path / CONFIG).write_text("what = 'my own'\n")
    with pytest.raises(OutputError, match="is of no run and would be replaced"):
        write_config(tmp_path, Cook("leek"), "cook")
    assert (tmp_path / CONFIG).read_text() == "what = 'my own'\n"


COMMANDS = {
    "demo": "--frames 7 --object chair --seed 3 --viewer-names a b",
    "scan": "chair-3 --slip 0.1 --tilt 20 --no-clutter --bumps 0.01 --frames 9 --speed 0.2 --up y",
    "replay": "bag --box 0 -1 2 3 4 5.5 --depth-range 0.5 2 --out a/b --viewer-port 0 --json",
    "watch": "--mount 0.1 0 0.9 0 30 --duration 3 --camera file.db3 --every 2",
    "gather": "--out s3://bucket/set --classes chair bed --train-starts 1.5 --from my.bag --size 4 3",
    "train": "--data x --net moon2018 --cells 32 64 32 --scans --catalogue a b --catalogue-share 0.5 "
    "--no-validation --damage 0.1 --epochs 3 --validation-salt s",
    "evaluate": "--data a b --yaw 0,45 --margin 1.2 --corrupt --split test",
    "calibrate": "a.onnx b.onnx --data x --real c d --max-error-rate 0.1",
    "reproduce": "rivals --data x --nets voxnet pointnet --epochs 24 moon2018=6 --precision bf16",
    "locate simulate": "--cameras 6 --seed 3 --size 640 480 --calibrate none --moved ceiling_0",
    "locate board": "--tags 0 100 --format png --square 0.05",
    "locate intrinsics": "a.png b.png --camera north --out room.json",
    "locate extrinsics": "floor --survey s.json --intrinsics i.json --out o.json --tag 1 0.1 0.3",
    "locate track": "images --calibration c.json --topic a=/b c=/d",
    "ros2": "--rate 3 --mount 0.1 0 0.9 0 30 --no-transforms --reliable --local --duration 5",
    "data": "convert ModelNet10 --net moon2018 --shard-size 64 --workers 2 --out s3://a/b",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_the_same_again_from_its_own_file(tmp_path: Path, name: str) -> None:
    def own(*words: str):
        found = parsed(name.split()[0], [*name.split()[1:], *words])
        return getattr(found, "what", found) if name.startswith("locate") else found

    command = own(*COMMANDS[name].split())
    given = [
        flag for flag in flags_of(type(command)).values() if flag.value(command) != flag.default
    ]
    assert len(given) >= 3
    write_config(tmp_path, command, name)
    again = own("--config", str(tmp_path / CONFIG))
    assert again.config == tmp_path / CONFIG
    assert replace(again, config=None) == command


def test_the_file_of_the_documentation_is_read(toml: Path) -> None:
    pages = [page.read_text() for page in (ROOT / "docs").glob("*.md")]
    (block,) = [
        text for page in pages for text in re.findall(r"```toml\n(# office.*?)```", page, re.S)
    ]
    toml.write_text(block)
    train = parsed("train", ["--data", "x", "--config", str(toml), "--epochs", "6"])
    assert (train.changes.epochs, train.changes.scans, train.changes.damage) == (6, True, 0.1)
    assert train.catalogue == (Path("sweethome3d.npz"),)


def test_a_parameter_file_stands_below_a_config_file_and_flags_above(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    parameters, config = tmp_path / "robot.yaml", tmp_path / "c.toml"
    parameters.write_text("/**: {ros__parameters: {rate: 1.0, queue: 2, frame: a}}\n")
    config.write_text(f"params-file = '{parameters}'\nqueue = 3\nframe = 'b'\n")
    node = parsed("ros2", ["--config", str(config), "--frame", "c"]).node
    assert (node.rate, node.queue, node.frame) == (1.0, 3, "c")


@pytest.mark.parametrize("command", ["demo", "train", "locate simulate", "data"])
def test_a_wrong_file_ends_a_command(toml: Path, capsys, command: str) -> None:
    toml.write_text("sead = 3\n")
    assert main([*command.split(), "--config", str(toml)]) == 2
    error = capsys.readouterr().err
    assert error == f"circumspect: {toml}: no key 'sead'; did you mean seed?\n"


def test_parsing_flags_loads_no_heavy_packages() -> None:
    code = """
import sys
from circumspect.cli.main import COMMANDS, parsed
words = {"scan": ["x"], "classify": ["x"], "replay": ["x"], "data": ["verify", "x"],
         "locate": ["simulate"], "train": ["--data", "x"], "gather": ["--out", "x"],
         "evaluate": ["--data", "x"], "calibrate": ["a", "b", "--data", "x"],
         "reproduce": ["table2"], "demo": [], "watch": [], "ros2": []}
heavy = {"numpy", "scipy", "torch", "mujoco", "onnxruntime", "trimesh", "matplotlib", "typeguard"}
for name, flags in words.items():
    parsed(name, flags)
    assert not (found := heavy & set(sys.modules)), f"{name} loads {found}"
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
