"""The flags `--model` and `--net`, and the record of the classifier of a run."""

from __future__ import annotations

from typing import Annotated

import tyro

from circumspect.errors import MissingExtraError

# Copied from `classification.shipped`, whose package imports SciPy: too slow for `--help`.
ROBOT = "robot"
MODELNET10 = "modelnet10"
NAMES = (ROBOT, MODELNET10)
ModelFlag = Annotated[str, tyro.conf.arg(metavar="NAME|FILE")]
NetFlag = Annotated[str | None, tyro.conf.arg(metavar="MODULE:NAME")]


def model_record(model: str) -> dict[str, str]:
    """The classifier and the hash of its file, for `config.json` of a run.

    Args:
        model: Value of `--model`; it must exist.

    Returns:
        `model` as given, and `sha256` of its file.
    """
    import hashlib

    from circumspect.classification.shipped import model_path

    content = model_path(model).read_bytes()
    return {"model": model, "sha256": hashlib.sha256(content).hexdigest()}


def name_net(net: str | None) -> None:
    """Register the network of a checkpoint, whose file contains only its name.

    Raises:
        InputError: The network can not be loaded, or is none.
        MissingExtraError: torch is not installed.
    """
    if net is None:
        return
    try:
        from circumspect.nets.registry import net_spec
    except ImportError as error:
        raise MissingExtraError(error.name or "torch", "train") from error
    net_spec(net)
