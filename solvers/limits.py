"""What all solvers are told: a tolerance, and limits; checked, and kept as kernels are compiled for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics.options import is_number
from lcpflex.errors import ModelError, as_number, shown

__all__ = ["check_limit", "check_tolerance", "keep_settings"]


def check_tolerance(tolerance: float) -> None:
    """A tolerance of the natural-map residual: refuses what no residual could mean."""
    if not 0.0 < as_number(tolerance) < 1e-2:
        raise ModelError(f"tolerance is {shown(tolerance)}: expected a number between 0 and 0.01 (relative residual)")


def check_limit(name: str, limit: int | None, needed: bool = False) -> None:
    """A limit of pivots or iterations: a positive integer or, unless it is ``needed``, None for the solver's own."""
    if limit is None and not needed:
        return
    if not (isinstance(limit, int) and not isinstance(limit, bool) and 0 < limit < 2**62):
        raise ModelError(f"{name} is {shown(limit)}: expected a positive integer{'' if needed else ' or None'}")


def keep_settings(solver: Any, *limits: str, needed: bool = False) -> None:
    """Keep the tolerance of a frozen solver as a float and these limits as integers or None, as kernels take them.

    ``needed``: None is refused.

    Raises ModelError as :func:`check_tolerance` and :func:`check_limit` do.
    """
    check_tolerance(solver.tolerance)
    object.__setattr__(solver, "tolerance", float(solver.tolerance))
    for name in limits:
        limit = getattr(solver, name)
        if isinstance(limit, np.integer | np.ndarray) and is_number(limit) and limit == int(limit):
            object.__setattr__(solver, name, int(limit))
        check_limit(name, getattr(solver, name), needed)
