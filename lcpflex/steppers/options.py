"""What steppers with contact problems are given alike."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.basics.arguments import whole_number
from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelError, shown
from lcpflex.solvers.user_solver import as_solver
from lcpflex.steppers.adaptive import AdaptiveStep

__all__ = ["CONTINUE", "RAISE", "keep_budget", "keep_solver"]

CONTINUE, RAISE = "continue", "raise"  # what a step does with a large island that is not solved


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


def keep_budget(stepper: Any) -> None:
    """Check what a stepper is to do with islands of many contacts.

    Raises
    ------
    ModelError
        For what is none of the choices, or no whole number >= 1.
    """
    if not isinstance(stepper.on_unsolved, str) or stepper.on_unsolved not in (CONTINUE, RAISE):
        raise ModelError(f'on_unsolved: {shown(stepper.on_unsolved)} was given, expected "{CONTINUE}" or "{RAISE}"')
    if stepper.budget is not None:
        object.__setattr__(stepper, "budget", whole_number("budget", stepper.budget, 1, why=", of factors, or None"))
