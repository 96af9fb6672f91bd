"""Which classifier a run was named by."""

from __future__ import annotations

import hashlib
from pathlib import Path


def weights_record(weights: Path | None) -> dict[str, str] | None:
    """For a run's `config.json`: the file and what tells its content from any other.

    Args:
        weights: That loaded already; None means the shipped classifier.

    Returns:
        `file` and `sha256`; None for the shipped one, which the version tells.
    """
    if weights is None:
        return None
    return {"file": str(weights), "sha256": hashlib.sha256(weights.read_bytes()).hexdigest()}
