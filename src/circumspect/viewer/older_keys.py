"""Keys of runs that older versions saved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.prediction import UNKNOWN_OBJECT

OLDER = {
    "known": "in_distribution", "conclusive": "confident", "seen": "coverage",
    "certain": "reliable", "sure": "accurate", "prior": "source",
}  # fmt: skip
"""Older key of an answer or a pose to that of today. Where an answer has `conclusive`, `reason` is
what is `end_reason` today."""
GATE, DOUBT, OPEN = "gate", "doubt", "open"
"""Older keys that are `pose_reason` today, and the gate of a registration that was used."""


def with_todays_keys(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row of a log, or a result, with the keys of today; one of today is as it is.

    Args:
        row: As it was read; nothing in it is believed.
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
    """Why an answer was not conclusive: older versions had the bounds of the default rule."""
    probability, seen = row.get("probability"), row.get("seen")
    if row.get("label") is None or row["conclusive"] is not False:
        return None
    if row.get("known") is False:
        return UNKNOWN_OBJECT
    if not isinstance(probability, int | float) or not isinstance(seen, int | float):
        return None
    return ConfidenceRule().reason(probability, seen) or None
