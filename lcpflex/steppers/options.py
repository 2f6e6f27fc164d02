"""What steppers with contact problems are given alike."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelError, shown
from lcpflex.solvers.user_solver import as_solver
from lcpflex.steppers.adaptive import AdaptiveStep

__all__ = ["keep_solver"]


def keep_solver(stepper: Any) -> None:
    """Check the solver of a stepper, its tolerance and, where it has one, its step control.

    Raises
    ------
    ModelError
        For what is none, or out of its range.
    """
    keep_number(stepper, "solver_tolerance", 0.0, math.inf, open_ends=True)
    adaptive = getattr(stepper, "adaptive", None)
    if not isinstance(adaptive, AdaptiveStep | None):
        raise ModelError(f"adaptive: {shown(adaptive)} was given, expected an AdaptiveStep or None")
    as_solver(stepper.solver)
