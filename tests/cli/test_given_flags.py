"""Errors that name a value get the name of its flag."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from circumspect.cli.given_flags import flags_named
from circumspect.errors import InputError


@dataclass(frozen=True)
class Command:
    slip: float = 0.05
    speed: float = 0.2
    from_: tuple[float, float] = (1.0, 2.0)
    name: str = "9"


def error_of(command: Command, message: str) -> str:
    with pytest.raises(InputError) as caught, flags_named(command, "slip", "speed", "from"):
        raise InputError(message)
    return str(caught.value)


@pytest.mark.parametrize(
    ("command", "message", "flag"),
    [
        (Command(slip=0.9), "slip is a share from 0 to 0.5, not 0.9", "--slip"),
        (Command(slip=float("nan")), "slip is a share, not nan", "--slip"),
        (Command(speed=1e-7), "a speed is more, not 1e-07 m/s", "--speed"),
        (Command(speed=-3.0), "it drives forward, not by -3°", "--speed"),
        (Command(from_=(5.0, 1.0)), "from near to far, not 5 and 1", "--from"),
    ],
)
def test_the_flag_is_named_by_its_value(command: Command, message: str, flag: str) -> None:
    assert error_of(command, message) == f"{flag}: {message}"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (Command(), "a share, not 0.9"),
        (Command(slip=0.9, speed=0.9), "a share, not 0.9"),
        (Command(), "a share, not 0.05"),
        (Command(slip=0.9), "chair.obj: is no mesh; 0.9 is no vertex"),
        (Command(slip=0.9), "give a mesh, not a cloud"),
        (Command(), "of nine, not 9"),
    ],
)
def test_a_value_of_no_flag_or_of_several_names_none(command: Command, message: str) -> None:
    assert error_of(command, message) == message
