"""What the pages tell people to type works: commands parse, Python runs, the tutorial runs."""

import importlib.util
import re
import shlex
import tomllib
from pathlib import Path

import pytest

from circumspect.cli.main import main, parsed
from circumspect.errors import CircumspectError
from circumspect.furniture import make_furniture
from circumspect.geometry import write_ply

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    page
    for page in (
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *sorted((ROOT / "docs").glob("*.md")),
        *sorted((ROOT / "docs").glob("models/*.md")),
        *sorted((ROOT / "docs").glob("development/*.md")),
    )
    if page.name != "benchmarks.md"
]
LOOSE = {"my_robot": "recordings.md"}
"""Names that a snippet expects of its reader, and the page where it is."""


def blocks(page, *languages):
    found = re.findall(r"^```(\w+)\n(.*?)^```", page.read_text(), flags=re.S | re.M)
    return [code for language, code in found if language in languages]


def shell_lines():
    for page in PAGES:
        for code in blocks(page, "sh", "bash"):
            joined = re.sub(r"\\\n\s*", "", code)
            for line in joined.splitlines():
                words = shlex.split(line, comments=True)
                if words:
                    yield pytest.param(words, id=f"{page.stem}: {line.split('#')[0].strip()}")


def numbers(words):
    """Places that a reader fills in, as X Y Z, filled in."""
    return ["1" if re.fullmatch(r"[A-Z]", word) else word for word in words]


@pytest.mark.parametrize("words", list(shell_lines()))
def test_shell_lines_name_what_exists(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Read while the flags are, for its values stand where no flag is given.
    (tmp_path / "robot.yaml").write_text("circumspect: {ros__parameters: {rate: 2.0}}")
    program, *rest = words
    if program == "circumspect":
        command = parsed(rest[0], numbers(rest[1:])) if "--help" not in rest else None
        assert command is None or hasattr(command, "run")
    elif program == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M)
        assert rest[0] in targets
    elif program.endswith(("python", "python3")):
        module = rest[1] if rest[0] == "-m" else None
        assert importlib.util.find_spec(module) if module else (ROOT / rest[0]).is_file()
    elif program == "torchrun":
        module, *rest = rest[rest.index("-m") + 1 :]
        assert module == "circumspect"
        assert hasattr(parsed(rest[0], numbers(rest[1:])), "run")
    elif program == "ray":
        assert rest[0] == "start"
    elif program.endswith("pip"):
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
        wanted = re.findall(r"\[([\w,]+)\]", rest[-1])
        assert set(",".join(wanted).split(",")) <= {"", *extras["optional-dependencies"]}
    else:
        assert program in {".", "apt-get", "cd", "dpkg", "git", "source"}, (
            "nothing checks this line"
        )


def python_blocks():
    for page in PAGES:
        for number, code in enumerate(blocks(page, "python")):
            if not any(name in code for name, home in LOOSE.items() if page.name == home):
                yield pytest.param(code, id=f"{page.stem}-{number}")


@pytest.mark.parametrize("code", list(python_blocks()))
def test_python_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_ply("chair.ply", make_furniture("chair", 3).sampled(20_000, 0))
    exec(compile(code, "snippet", "exec"), {})


@pytest.mark.parametrize("name", list(LOOSE))
def test_python_that_expects_something_runs_with_it(name, tmp_path, monkeypatch):
    from circumspect.simulation import SimulatedRobot, room

    monkeypatch.chdir(tmp_path)
    place = room(make_furniture("chair", 3))
    robot = SimulatedRobot(place.scene, place.start(0.0), place.mount)
    for code in blocks(ROOT / "docs" / LOOSE[name], "python"):
        exec(compile(code, "snippet", "exec"), {name: robot})


def test_the_tutorial_runs_from_its_first_line_to_its_last(tmp_path, monkeypatch, capsys):
    """In order and in one folder; frames are left out of the first scan, the rest is as written."""
    monkeypatch.chdir(tmp_path)
    for language, code in re.findall(
        r"^```(\w+)\n(.*?)^```", (ROOT / "docs" / "tutorial.md").read_text(), flags=re.S | re.M
    ):
        if language == "python":
            exec(compile(code, "tutorial", "exec"), {})
            continue
        for words in (shlex.split(line, comments=True) for line in code.splitlines()):
            if not words or words[0] != "circumspect":
                continue
            if "--frames" in words and "--record" not in words:
                words[words.index("--frames") + 1] = "3"
            assert main(words[1:]) == 0, f"{words}\n{capsys.readouterr().err}"
    told = capsys.readouterr().out
    assert re.search(r"^chair.ply: chair ", told, re.M)
    # The reader's first recording is named correctly, and again when it is replayed.
    assert len(re.findall(r"^Result: bathtub \(", told, re.M)) == 2
    assert {"run", "replayed", "bathtub.mcap", "chair-grid-turned.png"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_a_wrong_flag_does_not_pass_for_a_right_one():
    with pytest.raises((SystemExit, CircumspectError)):
        parsed("classify", ["chair.ply", "--colour", "red"])
