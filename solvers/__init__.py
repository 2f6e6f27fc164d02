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
    from lcpflex.solvers.clock import TimeLimit
    from lcpflex.solvers.comparison import CrossCheck, all_solvers, cross_check
    from lcpflex.solvers.cone import ConvexFriction
    from lcpflex.solvers.enumeration import Enumeration
    from lcpflex.solvers.fclib import load_fclib, save_fclib
    from lcpflex.solvers.files import load_problems, load_text_lcp, save_problems
    from lcpflex.solvers.friction import ContactProblem
    from lcpflex.solvers.gauss_seidel import GaussSeidel
    from lcpflex.solvers.lemke import Lemke
    from lcpflex.solvers.mixed import BoxedLcp, MixedLcp
    from lcpflex.solvers.newton import MinMapNewton
    from lcpflex.solvers.own import OwnSolver
    from lcpflex.solvers.principal_pivoting import PrincipalPivoting
    from lcpflex.solvers.problem import Lcp, Solution, Status, accept
    from lcpflex.solvers.quadratic_program import QuadraticProgram
    from lcpflex.solvers.replays import Replay, replay
    from lcpflex.solvers.siconos_files import load_siconos, load_siconos_contacts, load_siconos_lcp, load_siconos_mlcp
    from lcpflex.solvers.spatial import SpatialContactProblem

__all__ = [
    "Auto",
    "BlockGaussSeidel",
    "BoxedLcp",
    "ContactProblem",
    "ConvexFriction",
    "CrossCheck",
    "Enumeration",
    "GaussSeidel",
    "Lcp",
    "Lemke",
    "MinMapNewton",
    "MixedLcp",
    "OwnSolver",
    "PrincipalPivoting",
    "QuadraticProgram",
    "Replay",
    "Solution",
    "SpatialContactProblem",
    "Status",
    "TimeLimit",
    "accept",
    "all_solvers",
    "cross_check",
    "load_fclib",
    "load_problems",
    "load_siconos",
    "load_siconos_contacts",
    "load_siconos_lcp",
    "load_siconos_mlcp",
    "load_text_lcp",
    "replay",
    "save_fclib",
    "save_problems",
    "solve_lcp",
]

_HOME = {
    "Auto": "lcpflex.solvers.auto",
    "BlockGaussSeidel": "lcpflex.solvers.block_gauss_seidel",
    "BoxedLcp": "lcpflex.solvers.mixed",
    "ContactProblem": "lcpflex.solvers.friction",
    "ConvexFriction": "lcpflex.solvers.cone",
    "CrossCheck": "lcpflex.solvers.comparison",
    "Enumeration": "lcpflex.solvers.enumeration",
    "GaussSeidel": "lcpflex.solvers.gauss_seidel",
    "Lcp": "lcpflex.solvers.problem",
    "Lemke": "lcpflex.solvers.lemke",
    "MinMapNewton": "lcpflex.solvers.newton",
    "MixedLcp": "lcpflex.solvers.mixed",
    "OwnSolver": "lcpflex.solvers.own",
    "PrincipalPivoting": "lcpflex.solvers.principal_pivoting",
    "QuadraticProgram": "lcpflex.solvers.quadratic_program",
    "Replay": "lcpflex.solvers.replays",
    "Solution": "lcpflex.solvers.problem",
    "SpatialContactProblem": "lcpflex.solvers.spatial",
    "Status": "lcpflex.solvers.problem",
    "TimeLimit": "lcpflex.solvers.clock",
    "accept": "lcpflex.solvers.problem",
    "all_solvers": "lcpflex.solvers.comparison",
    "cross_check": "lcpflex.solvers.comparison",
    "load_fclib": "lcpflex.solvers.fclib",
    "load_problems": "lcpflex.solvers.files",
    "load_siconos": "lcpflex.solvers.siconos_files",
    "load_siconos_contacts": "lcpflex.solvers.siconos_files",
    "load_siconos_lcp": "lcpflex.solvers.siconos_files",
    "load_siconos_mlcp": "lcpflex.solvers.siconos_files",
    "load_text_lcp": "lcpflex.solvers.files",
    "replay": "lcpflex.solvers.replays",
    "save_fclib": "lcpflex.solvers.fclib",
    "save_problems": "lcpflex.solvers.files",
    "solve_lcp": "lcpflex.solvers.auto",
}


def __getattr__(name: str) -> Any:
    """Load a solver at its first use, so that importing the package costs nothing."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    from lcpflex.basics.arguments import nearest

    raise AttributeError(f"module {__name__!r} has no attribute {name!r}{nearest(name, __all__)}")


def __dir__() -> list[str]:
    return sorted(__all__)
