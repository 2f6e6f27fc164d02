"""Solvers of linear complementarity problems, 0 <= z _|_ w = M z + q >= 0, and the contact problems that lead to them.

The room knows numpy and no mechanics beyond the contact problem of :class:`ContactProblem`. Letters are those of
Cottle, Pang & Stone, *The Linear Complementarity Problem*. Every solver is a frozen dataclass with
``solve(problem, guess=None) -> Solution`` and ends in :func:`accept`, which alone may say "solved".
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if __name__ != "lcpflex.solvers":
    raise ImportError("this package is part of lcpflex: import it as `lcpflex.solvers`")

if TYPE_CHECKING:
    from lcpflex.solvers.friction import ContactProblem
    from lcpflex.solvers.lemke import Lemke
    from lcpflex.solvers.problem import Lcp, Solution, Status, accept
    from lcpflex.solvers.quadratic_program import QuadraticProgram

__all__ = ["ContactProblem", "Lcp", "Lemke", "QuadraticProgram", "Solution", "Status", "accept"]

_HOME = {
    "ContactProblem": "friction",
    "Lcp": "problem",
    "Lemke": "lemke",
    "QuadraticProgram": "quadratic_program",
    "Solution": "problem",
    "Status": "problem",
    "accept": "problem",
}


def __getattr__(name: str) -> Any:
    """Load a solver at its first use, so that importing the package costs nothing."""
    if name in _HOME:
        return getattr(import_module(f"lcpflex.solvers.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
