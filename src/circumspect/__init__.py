"""circumspect: name an object from any side."""

from __future__ import annotations

__version__ = "0.1.0"
