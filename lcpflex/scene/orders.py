"""What is asked of a flexible body that its scene reduces, and refused for one that has its modes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lcpflex.errors import ModelError

__all__ = ["is_reducible", "refuse_options"]


def is_reducible(body: Any, kinds: tuple[type, ...]) -> bool:
    """Whether it is a flexible body without modes; ``kinds`` of bodies that have them, or none."""
    return not isinstance(body, (*kinds, type)) and hasattr(body, "reduce")


def refuse_options(options: Mapping[str, Any], kind: str, such: str) -> None:
    """Raise ModelError for an option that was given for a body of a ``kind`` that has its modes."""
    for option, value in options.items():
        if value is not None:
            raise ModelError(
                f"{option}: it was given for a {kind}, which has its modes, expected an unreduced one such as {such}"
            )
