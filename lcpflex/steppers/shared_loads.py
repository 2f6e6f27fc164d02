"""Runs whose motion depends on how contacts share a load, in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lcpflex.model.layout import is_spatial

__all__ = ["shared_loads"]


def shared_loads(model: Any, work: Any, name: Callable[[int], str]) -> list[str]:
    """That the motion is one choice of several, as far as the workspace of a run has met that; of space alone."""
    told = int(work.impulses.solver.shares.told) if is_spatial(model) else 0
    if not told:
        return []
    return [
        "contacts that slide share a load in more ways than one, and friction depends on their shares (contact "
        f"{name(told - 1)}): taken are the least forces, which contacts that all give way alike have"
    ]
