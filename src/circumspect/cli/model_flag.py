"""The flag `--model` of every command that names objects."""

from __future__ import annotations

from typing import Annotated

import tyro

# As in `classification.shipped`, whose package brings SciPy along: too slow for `--help`.
ROBOT = "robot"
MODELNET10 = "modelnet10"
NAMES = (ROBOT, MODELNET10)
ModelFlag = Annotated[str, tyro.conf.arg(metavar="NAME|FILE")]
