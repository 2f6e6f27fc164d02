"""The version of the package; that of ``pyproject.toml`` is the same."""

from __future__ import annotations

__all__ = ["VERSION"]

VERSION = "0.1.0"
