"""Motions that have grown out of all bounds, of which checks beside that of energy have nothing to tell."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["has_grown"]

BOUND = np.finfo(float).max ** 0.25  # stiffnesses, products of forces and places, have no squares beyond


def has_grown(result: Result) -> bool:
    """Whether a place or a velocity at the end is no number, or so large that what is computed of it is none."""
    return not (np.abs(result.q[-1:]).max(initial=0.0) < BOUND and np.abs(result.u[-1:]).max(initial=0.0) < BOUND)
