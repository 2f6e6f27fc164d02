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
    from lcpflex.solvers.auto import Auto, solve_lcp
    from lcpflex.solvers.block_gauss_seidel import BlockGaussSeidel
    from lcpflex.solvers.enumeration import Enumeration
    from lcpflex.solvers.friction import ContactProblem
    from lcpflex.solvers.gauss_seidel import GaussSeidel
    from lcpflex.solvers.lemke import Lemke
    from lcpflex.solvers.mixed import BoxedLcp, MixedLcp
    from lcpflex.solvers.newton import MinMapNewton
    from lcpflex.solvers.principal_pivoting import PrincipalPivoting
    from lcpflex.solvers.problem import Lcp, Solution, Status, accept
    from lcpflex.solvers.quadratic_program import QuadraticProgram

__all__ = [
    "Auto",
    "BlockGaussSeidel",
    "BoxedLcp",
    "ContactProblem",
    "Enumeration",
    "GaussSeidel",
    "Lcp",
    "Lemke",
    "MinMapNewton",
    "MixedLcp",
    "PrincipalPivoting",
    "QuadraticProgram",
    "Solution",
    "Status",
    "accept",
    "solve_lcp",
]

_HOME = {
    "Auto": "auto",
    "BlockGaussSeidel": "block_gauss_seidel",
    "BoxedLcp": "mixed",
    "ContactProblem": "friction",
    "Enumeration": "enumeration",
    "GaussSeidel": "gauss_seidel",
    "Lcp": "problem",
    "Lemke": "lemke",
    "MinMapNewton": "newton",
    "MixedLcp": "mixed",
    "PrincipalPivoting": "principal_pivoting",
    "QuadraticProgram": "quadratic_program",
    "Solution": "problem",
    "Status": "problem",
    "accept": "problem",
    "solve_lcp": "auto",
}


def __getattr__(name: str) -> Any:
    """Load a solver at its first use, so that importing the package costs nothing."""
    if name in _HOME:
        return getattr(import_module(f"lcpflex.solvers.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
