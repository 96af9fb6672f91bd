"""Which classifier a run was named by."""

from __future__ import annotations

import hashlib


def model_record(model: str) -> dict[str, str]:
    """For a run's `config.json`: the classifier, and the hash of its file.

    Args:
        model: What `--model` says; it was loaded already.

    Returns:
        `model` as it was given, and `sha256` of the ONNX file.
    """
    from circumspect.classification.shipped import model_path

    content = model_path(model).read_bytes()
    return {"model": model, "sha256": hashlib.sha256(content).hexdigest()}
