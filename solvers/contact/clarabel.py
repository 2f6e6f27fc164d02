"""Clarabel as conic programs of contact ask it: min 1/2 x.P x + c.x over cones |x_T| <= x_N, or the dual of that."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.clock import limited, remaining
from lcpflex.solvers.guard import words_of

__all__ = ["SHORT_STEP", "STEP", "SUCCESS", "conic_program"]

SUCCESS = ("Solved", "AlmostSolved")
ACCURACY = 1e-12  # asked of Clarabel: near what it can reach in double precision
STEP, SHORT_STEP = 0.99, 0.9  # of the way to the edge of a cone; shorter ones seldom get stuck in rounding


def conic_program(
    P: Any, B: Any, c: FloatArray, smooth: int, rows: int, step: float = STEP
) -> tuple[FloatArray, int, str]:
    """x (m,), the iterations and what Clarabel says of it.

    P (m, m) symmetric; or None and B (m, k) with P = B B^T: then min 1/2 |y|^2 with B y + c in the dual cones is
    solved, which never forms P, and x is its multiplier. The first ``smooth`` unknowns are >= 0, the others in cones
    of so many ``rows`` each. step: how far an iteration may go, of the way to the edge of a cone.
    """
    m = len(c)
    cones = [libs.clarabel.NonnegativeConeT(smooth)] if smooth else []
    cones += [libs.clarabel.SecondOrderConeT(rows)] * ((m - smooth) // rows)
    settings = libs.clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_step_fraction = step
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = ACCURACY
    if limited():
        settings.time_limit = max(remaining(), 1e-6)
    if B is None:
        squares = libs.sparse.triu(libs.sparse.csc_matrix(P), format="csc")
        A = -libs.sparse.identity(m, format="csc")
        objective, bound = c, np.zeros(m)
    else:
        squares, A = libs.sparse.identity(B.shape[1], format="csc"), -libs.sparse.csc_matrix(B)
        objective, bound = np.zeros(B.shape[1]), c
    try:
        found = libs.clarabel.DefaultSolver(squares, objective, A, bound, cones, settings).solve()
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # a panic in Rust is no Exception; what it says is passed on
        return np.full(m, np.nan), 0, words_of(error)
    said = str(found.status)
    if B is not None and said == "PrimalInfeasible":  # the dual program is named from its own side
        said = "DualInfeasible"
    return np.array(found.x if B is None else found.z), int(found.iterations), said
