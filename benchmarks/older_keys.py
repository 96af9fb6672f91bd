"""Current names of the keys in older records."""

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
"""Older keys and their current names."""


def with_current_keys(record: Mapping[str, Any]) -> dict[str, Any]:
    """A record with current keys."""
    return {OLDER.get(key, key): value for key, value in record.items()}
