"""Snippets of the pages work: commands parse, Python runs, the tutorial runs."""

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
        ROOT / "docs" / "api" / "index.md",
        *sorted((ROOT / "docs").glob("models/*.md")),
        *sorted((ROOT / "docs").glob("development/*.md")),
    )
    if page.name != "benchmarks.md"
]
LOOSE = {"my_robot": "recordings.md"}
"""Names that a snippet expects to be defined, and its page."""


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
    """The words with placeholders such as X Y Z filled in."""
    return ["1" if re.fullmatch(r"[A-Z]", word) else word for word in words]


@pytest.mark.parametrize("words", list(shell_lines()))
def test_shell_snippets_name_existing_commands_and_flags(words, tmp_path, monkeypatch):
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
    elif program == "docker":
        assert (ROOT / "Dockerfile").is_file()
        if rest[0] == "run":
            command, *rest = rest[rest.index("circumspect") + 1 :]
            assert hasattr(parsed(command, rest), "run")
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
def test_python_snippets_run(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_ply("chair.ply", make_furniture("chair", 3).sampled(20_000, 0))
    exec(compile(code, "snippet", "exec"), {})


@pytest.mark.parametrize("name", list(LOOSE))
def test_python_snippets_with_given_names_run(name, tmp_path, monkeypatch):
    from circumspect.simulation import SimulatedRobot, room

    monkeypatch.chdir(tmp_path)
    place = room(make_furniture("chair", 3))
    robot = SimulatedRobot(place.scene, place.start(0.0), place.mount)
    for code in blocks(ROOT / "docs" / LOOSE[name], "python"):
        exec(compile(code, "snippet", "exec"), {name: robot})


def test_the_whole_tutorial_runs(tmp_path, monkeypatch, capsys):
    """In order and in one folder, as written."""
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
            assert main(words[1:]) == 0, f"{words}\n{capsys.readouterr().err}"
    printed = capsys.readouterr().out
    assert re.search(r"^chair.ply: chair ", printed, re.M)
    # The scan ends with a confident answer, and so does the replay of its recording.
    assert len(re.findall(r"^Result: sofa \(\d+ %\), .* Confident\.", printed, re.M)) == 2
    assert {"run", "replayed", "sofa.mcap", "chair-grid-turned.png"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_contributing_names_files_that_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    roots = (ROOT, ROOT / "src", ROOT / "src" / "circumspect")
    named = set(re.findall(r"`((?:[\w.-]+/)+[\w.-]+)`", text))
    assert len(named) > 10
    missing = {name for name in named if not any((root / name).exists() for root in roots)}
    assert not missing


def test_a_wrong_flag_in_a_snippet_is_found():
    with pytest.raises((SystemExit, CircumspectError)):
        parsed("classify", ["chair.ply", "--colour", "red"])
