"""Solvers of linear complementarity problems, 0 <= z _|_ w = M z + q >= 0, and the contact problems that lead to them.

The room knows numpy and no mechanics beyond the contact problem of :class:`ContactProblem`. Letters are those of
Cottle, Pang & Stone, *The Linear Complementarity Problem*. Every solver is a frozen dataclass with
``solve(problem, guess=None) -> Solution`` and ends in :func:`accept`, which alone may say "solved".
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.solvers.auto import Auto, solve_lcp
    from lcpflex.solvers.benchmark.comparison import CrossCheck, all_solvers, cross_check
    from lcpflex.solvers.benchmark.fclib import load_fclib, save_fclib
    from lcpflex.solvers.benchmark.files import load_problems, load_text_lcp, save_problems
    from lcpflex.solvers.benchmark.replays import Replay, replay
    from lcpflex.solvers.benchmark.siconos_files import (
        load_siconos,
        load_siconos_contacts,
        load_siconos_lcp,
        load_siconos_mlcp,
    )
    from lcpflex.solvers.contact.block_gauss_seidel import BlockGaussSeidel
    from lcpflex.solvers.contact.cone import ConvexFriction
    from lcpflex.solvers.contact.problem import ContactProblem
    from lcpflex.solvers.contact.spatial import SpatialContactProblem
    from lcpflex.solvers.lcp.enumeration import Enumeration
    from lcpflex.solvers.lcp.gauss_seidel import GaussSeidel
    from lcpflex.solvers.lcp.lemke import Lemke
    from lcpflex.solvers.lcp.newton import MinMapNewton
    from lcpflex.solvers.lcp.principal_pivoting import PrincipalPivoting
    from lcpflex.solvers.mixed.problems import BoxedLcp, MixedLcp
    from lcpflex.solvers.problem import Lcp, Solution, Status, accept
    from lcpflex.solvers.quadratic_program import QuadraticProgram
    from lcpflex.solvers.time_limit import TimeLimit
    from lcpflex.solvers.user_solver import UserSolver

if __name__ != "lcpflex.solvers":
    raise ImportError("this package is part of lcpflex: import it as `lcpflex.solvers`")

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
    "UserSolver",
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

__getattr__, __dir__ = attach(__name__, renamed={"OwnSolver": "UserSolver"})
