"""How data classes become flags: what users read and what they get."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import pytest
import tyro

from circumspect.cli.flags import parse
from circumspect.cli.main import COMMANDS, main


@dataclass(frozen=True)
class Cook:
    """Make soup.

    $ cook leek
    """

    what: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SOUP")]
    """Which soup, of all the many that there are between the sea and the mountains and beyond
    them, as long as it is hot."""
    salt: float | None = None
    """Grams."""
    pot: Path | None = None
    """Where."""
    heat: Literal["low", "high"] | None = None
    """How."""
    box: tuple[float, float] | None = None
    """Two numbers."""
    lid: bool = True
    """Leave the lid off."""
    stir: bool = False
    """Stir."""
    bowls: int = 2
    """How many."""


def cook(*words):
    return parse(Cook, "cook", words)


def exit_code_and_output(capsys, *words):
    with pytest.raises(SystemExit) as stop:
        cook(*words)
    out, err = capsys.readouterr()
    return stop.value.code, out + err


def test_values_are_parsed_to_their_types():
    assert cook("leek") == Cook("leek")
    given = cook("leek", "--salt", "2.5", "--pot", "a/b", "--heat", "low", "--box", "1", "-2")
    assert given == Cook("leek", 2.5, Path("a/b"), "low", (1.0, -2.0))
    assert cook("leek", "--stir", "--no-lid", "--bowls", "3") == Cook(
        "leek", stir=True, lid=False, bowls=3
    )


def test_help_shows_no_python_values(capsys):
    code, text = exit_code_and_output(capsys, "--help")
    assert code == 0
    assert "None" not in text
    assert "default: 2" in text, "defaults that say something stay"
    assert "--salt FLOAT" in text
    assert "--no-stir" not in text
    # The docstring's lines are no lines of the help.
    assert "and beyond them, as long" in " ".join(text.replace("│", " ").split())
    assert "$ cook leek" in text


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (("--salt", "much"), "much"),
        (("--heat", "mild"), "low"),
        (("--box", "1"), "2"),
        (("--sallt", "1"), "--salt"),
        (("--bowls", "many"), "many"),
    ],
)
def test_errors_name_the_wrong_flag_or_value(capsys, flags, word):
    code, text = exit_code_and_output(capsys, "leek", *flags)
    assert code == 2
    assert word in text
    assert "None" not in text
    assert "Traceback" not in text


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_shows_lines_to_copy_and_no_none(name, capsys):
    with pytest.raises(SystemExit):
        main([name, "--help"])
    text = capsys.readouterr().out
    assert f"$ circumspect {name}" in text.split("╭")[0]
    assert "None" not in text
    assert max(len(line) for line in text.splitlines()[1:]) <= 80


def test_a_command_of_a_missing_package_names_it_and_is_not_listed(capsys, monkeypatch):
    monkeypatch.setattr("circumspect.cli.main.find_spec", lambda name: None)
    assert main(["reproduce", "table2"]) == 2
    error = capsys.readouterr().err
    assert "pip install ./experiments" in error
    assert error.count("\n") == 1
    assert main(["--help"]) == 0
    assert "reproduce" not in capsys.readouterr().out
    assert main(["completion", "bash"]) == 0
    assert "reproduce" not in capsys.readouterr().out


def test_help_of_a_command_by_the_other_word(capsys):
    with pytest.raises(SystemExit):
        main(["help", "grid"])
    assert "circumspect grid" in capsys.readouterr().out


def test_flags_before_the_command_are_refused_with_the_right_order(capsys):
    assert main(["--json", "classify", "x"]) == 2
    assert "circumspect COMMAND --json" in capsys.readouterr().err


def test_a_misspelt_object_gets_a_suggestion(capsys):
    assert main(["scan", "chiar-7"]) == 2
    assert "did you mean chair?" in capsys.readouterr().err
