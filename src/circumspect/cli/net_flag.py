"""The flag `--net` of commands that read checkpoints."""

from __future__ import annotations

from typing import Annotated

import tyro

from circumspect.errors import MissingExtraError

NetFlag = Annotated[str | None, tyro.conf.arg(metavar="MODULE:NAME")]


def name_net(net: str | None) -> None:
    """Make the network of a checkpoint known, whose file names it without its code.

    Raises:
        InputError: It can not be loaded, or is no network.
        MissingExtraError: It needs torch.
    """
    if net is None:
        return
    try:
        from circumspect.nets.registry import net_spec
    except ImportError as error:
        raise MissingExtraError(error.name or "torch", "train") from error
    net_spec(net)
