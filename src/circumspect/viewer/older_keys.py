"""Conversion of keys in runs that older versions saved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.prediction import UNKNOWN_OBJECT

OLDER = {
    "known": "in_distribution", "conclusive": "confident", "seen": "coverage",
    "certain": "reliable", "sure": "accurate", "prior": "source",
}  # fmt: skip
"""Older keys of an answer or a pose, and their current names. If an answer has `conclusive`, its
`reason` is the current `end_reason`."""
GATE, DOUBT, OPEN = "gate", "doubt", "open"
"""Older keys of the current `pose_reason`, and the gate value of an accepted registration."""


def with_todays_keys(row: Mapping[str, Any]) -> dict[str, Any]:
    """Convert a row of a log, or a result, to the current keys; current rows are unchanged.

    Args:
        row: The row as read; untrusted.
    """
    found = {OLDER.get(key, key): row[key] for key in row if key not in (GATE, DOUBT)}
    if GATE in row:
        gate = None if row[GATE] == OPEN else row[GATE]
        found["pose_reason"] = "; ".join(str(why) for why in (gate, row.get(DOUBT)) if why)
    if "conclusive" in row:
        found.pop("reason", None)
        if "reason" in row:
            found["end_reason"] = row["reason"]
        found["reason"] = _reason(row)
    return found


def _reason(row: Mapping[str, Any]) -> str | None:
    """Why an answer was not conclusive; older versions had the bounds of the default rule."""
    probability, seen = row.get("probability"), row.get("seen")
    if row.get("label") is None or row["conclusive"] is not False:
        return None
    if row.get("known") is False:
        return UNKNOWN_OBJECT
    if not isinstance(probability, int | float) or not isinstance(seen, int | float):
        return None
    return ConfidenceRule().reason(probability, seen) or None
