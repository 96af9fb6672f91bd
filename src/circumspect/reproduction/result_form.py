"""Whether a stored result has the form that its stage gives it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

Form = type | Sequence[Any] | Mapping[str, Any]
"""A type, or forms in a list or a dictionary."""


def fits(found: Any, form: Form) -> bool:
    """Whether JSON types are as a form says: the same keys, lengths and types; numbers finite."""
    if isinstance(form, type):
        return type(found) is form and (form is not float or math.isfinite(found))
    if isinstance(form, Mapping):
        same = isinstance(found, dict) and found.keys() == form.keys()
        return same and all(fits(found[key], inner) for key, inner in form.items())
    same = isinstance(found, list) and len(found) == len(form)
    return same and all(map(fits, found, form))
