"""Why a scan ends."""

from __future__ import annotations

from enum import StrEnum


class EndReason(StrEnum):
    """Fixed reasons why a scan ends; the values are the texts in its file.

    The other reasons contain numbers, or come from the planner.
    """

    LOST = "lost: no pose has been reliable for too long"
    NO_OBJECT = "no object in view after a look round"
    INTERRUPTED = "interrupted"


class ScanEnded(Exception):  # noqa: N818 - not an error
    """Ends a scan from inside; its message is the reason."""
