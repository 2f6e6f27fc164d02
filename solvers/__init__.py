"""Solvers of linear complementarity problems, 0 <= z _|_ w = M z + q >= 0, and the contact problems that lead to them.

The room knows numpy and no mechanics beyond the contact problem of :class:`ContactProblem`. Letters are those of
Cottle, Pang & Stone, *The Linear Complementarity Problem*. Every solver is a frozen dataclass with
``solve(problem, guess=None) -> Solution`` and ends in :func:`accept`, which alone may say "solved".
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.solvers.acceptance import accept as accept
    from lcpflex.solvers.auto import Auto as Auto, solve_lcp as solve_lcp
    from lcpflex.solvers.benchmark.comparison import (
        CrossCheck as CrossCheck,
        all_solvers as all_solvers,
        cross_check as cross_check,
    )
    from lcpflex.solvers.benchmark.fclib import load_fclib as load_fclib, save_fclib as save_fclib
    from lcpflex.solvers.benchmark.files import (
        load_problems as load_problems,
        load_text_lcp as load_text_lcp,
        save_problems as save_problems,
    )
    from lcpflex.solvers.benchmark.replays import Replay as Replay, replay as replay
    from lcpflex.solvers.benchmark.siconos_files import (
        load_siconos as load_siconos,
        load_siconos_contacts as load_siconos_contacts,
        load_siconos_lcp as load_siconos_lcp,
        load_siconos_mlcp as load_siconos_mlcp,
    )
    from lcpflex.solvers.contact.block_gauss_seidel import BlockGaussSeidel as BlockGaussSeidel
    from lcpflex.solvers.contact.cone import ConvexFriction as ConvexFriction
    from lcpflex.solvers.contact.cones.conic import ConicFixedPoint as ConicFixedPoint
    from lcpflex.solvers.contact.cones.facets import FacetedCone as FacetedCone
    from lcpflex.solvers.contact.cones.several import contact_solutions as contact_solutions
    from lcpflex.solvers.contact.cones.solver import AlartCurnier as AlartCurnier
    from lcpflex.solvers.contact.problem import ContactProblem as ContactProblem
    from lcpflex.solvers.contact.spatial import SpatialContactProblem as SpatialContactProblem
    from lcpflex.solvers.lcp.enumeration import Enumeration as Enumeration
    from lcpflex.solvers.lcp.gauss_seidel import GaussSeidel as GaussSeidel
    from lcpflex.solvers.lcp.lemke import Lemke as Lemke
    from lcpflex.solvers.lcp.newton import MinMapNewton as MinMapNewton
    from lcpflex.solvers.lcp.principal_pivoting import PrincipalPivoting as PrincipalPivoting
    from lcpflex.solvers.mixed.problems import BoxedLcp as BoxedLcp, MixedLcp as MixedLcp
    from lcpflex.solvers.problem import Lcp as Lcp, Solution as Solution, Status as Status
    from lcpflex.solvers.quadratic_program import QuadraticProgram as QuadraticProgram
    from lcpflex.solvers.time_limit import TimeLimit as TimeLimit
    from lcpflex.solvers.user_solver import UserSolver as UserSolver

if __name__ != "lcpflex.solvers":
    raise ImportError("this package is part of lcpflex: import it as `lcpflex.solvers`")

__getattr__, __dir__ = attach(__name__, renamed={"OwnSolver": "UserSolver"})
