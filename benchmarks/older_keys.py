"""Keys of results that older versions measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

OLDER = {
    "worst_trusted_m": "worst_reliable_m",
    "worst_trusted_sigmas": "worst_reliable_sigmas",
    "trusted": "reliable",
    "worst_sure_m": "worst_accurate_m",
    "sure": "accurate",
}
"""Older key of a record to that of today."""


def with_todays_keys(record: Mapping[str, Any]) -> dict[str, Any]:
    """A record with the keys of today."""
    return {OLDER.get(key, key): value for key, value in record.items()}
