"""Exchanges row by row in the scale of each: for a point that solves an LCP as a whole, and not where it is small.

Pivoting ends where all signs are right but for the rounding of the largest row. Where rows differ by many orders, the
small ones are then not looked at. From the active set that it ended with, what is wrong by the terms of its own row
(or contact) is exchanged; z is solved for anew on each set, with one refinement, after which every row is right to its
own rounding.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.lcp.exact_residual import own_parts
from lcpflex.solvers.lcp.lemke import lemke_workspace
from lcpflex.solvers.lcp.pivoting import solve_active
from lcpflex.solvers.problem import Lcp, Solution, accept

__all__ = ["REPAIRED", "repaired"]

REPAIRED = "exchanges row by row"
WRONG = 1e-14  # a sign counts as wrong beyond this fraction of the terms of its row
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones
LIMIT = 60  # solves

Flags = npt.NDArray[np.bool_]


def repaired(problem: Lcp, found: Solution, tolerance: float) -> Solution | None:
    """A better solution than ``found`` (which is none) by exchanges from its active set; None where there is none.

    Only of a point that is one as far as the problem as a whole is concerned: others need another method.
    """
    alike, units = problem.balanced()
    M, q = alike._data
    with np.errstate(all="ignore"):
        z = found.z if units is None else units.inward(found.z)
        if not natural_residual(M, q, z, len(q)) <= tolerance:
            return None
        rows = np.abs(M).max(axis=1, initial=0.0)
        basic: Flags = np.where(rows > 0.0, rows, 1.0) * z > M @ z + q if found.active is None else found.active == 1
        best, fewest, patience, seen = found, len(q) + 1, PATIENCE, set()
        for count in range(1, LIMIT + 1):
            if basic.tobytes() in seen:
                break
            seen.add(basic.tobytes())
            basic, z, wrong = _solved(alike, basic)
            point = np.maximum(z, 0.0)
            told = accept(
                problem,
                point if units is None else units.outward(point),
                tolerance=tolerance,
                iterations=count,
                route=REPAIRED,
                active=basic.astype(np.int64),
            )
            if told.solved or told.residual < best.residual:
                best = told
            if told.solved or not wrong.any():
                break
            some = int(wrong.sum())
            fewest, patience = (some, PATIENCE) if some < fewest else (fewest, patience - 1)
            if patience < 0:
                wrong[: np.flatnonzero(wrong)[-1]] = False
            basic = basic ^ wrong
    return None if best is found else best


def _solved(problem: Lcp, basic: Flags) -> tuple[Flags, FloatArray, Flags]:
    """The set without what its rank leaves out, z on it, and which signs are wrong beyond the rounding of their row."""
    M, q = problem._data
    n = len(q)
    z, change = np.zeros(n), np.zeros(n)
    table, basis = lemke_workspace(n)
    basis[:n] = basic
    solve_active(M, q, n, z, table, basis)
    basic = basis[:n] == 1
    solve_active(M, M @ z + q, n, change, table, basis)
    if np.isfinite(change).all():
        z += change
    w = M @ z + q
    terms = own_parts((M, q), z, w, None).terms
    weight = np.abs(M) / np.where(terms > 0.0, terms, 1.0)[:, None]  # what z_i is worth in the rows that it acts on
    dropped = np.abs(z) * weight.max(axis=0, initial=0.0)
    return basic, z, np.where(basic, (z < 0.0) & (dropped > WRONG), w < -WRONG * terms)
