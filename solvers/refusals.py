"""Why solvers of LCPs do not take friction in space, in the words of their refusals."""

from __future__ import annotations

from typing import Any

from lcpflex.errors import ModelError, shown
from lcpflex.solvers.solution import Solution

__all__ = ["NO_LCP", "check_answer", "has_cones", "no_cones", "only_cones"]

NO_LCP = (
    "SpatialContactProblem is no LCP, as friction in space obeys a cone; expected a solver that takes cones: Auto(), "
    "BlockGaussSeidel(), AlartCurnier(), ConicFixedPoint(), or FacetedCone() for the LCP of a faceted one"
)


def has_cones(problem: Any) -> bool:
    """Whether it is a contact problem in space."""
    return getattr(type(problem), "cones", False) is True


def no_cones(solver: Any, problem: Any) -> str:
    """Why a solver of LCPs refuses a contact problem in space; empty for any other problem."""
    return f"{type(solver).__name__} solves LCPs: {NO_LCP}" if has_cones(problem) else ""


def only_cones(solver: Any, problem: Any) -> str:
    """Why a solver that knows cones alone refuses any other problem; empty for a contact problem in space."""
    if has_cones(problem):
        return ""
    kind = type(problem).__name__
    return f"problem: {kind} was given to {type(solver).__name__}, expected a SpatialContactProblem"


def check_answer(found: Any) -> Solution:
    """The answer of a solver. Raises ModelError for anything but a :class:`Solution`."""
    if not isinstance(found, Solution):
        raise ModelError(f"solver returned {shown(found)}: expected a Solution")
    return found
