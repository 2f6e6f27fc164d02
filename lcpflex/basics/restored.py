"""Frozen dataclasses with slots, as copies and pickles restore them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

__all__ = ["restore"]


def restore(owner: Any, state: list[Any]) -> None:
    """Set the fields of a copy or of what is unpickled; its arrays are read-only again."""
    for part, value in zip(fields(owner), state, strict=True):
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        object.__setattr__(owner, part.name, value)
