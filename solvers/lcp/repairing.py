"""Exchanges row by row in the scale of each: for a point that solves an LCP as a whole, and not where it is small.

Pivoting ends where all signs are right but for the rounding of the largest row. Where rows differ by many orders, the
small ones are then not looked at. From the active set that it ended with, what is wrong by the terms of its own row
(or contact) is exchanged; z is solved for anew on each set, with one refinement, after which every row is right to its
own rounding.

Where contacts are redundant, another solution on the same set is another share of the load, and what was pressed is
pulled. Then Newton's method on the min-map goes on instead, by the least change of z that makes the rows of the set
right, each relative to its own terms.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.lcp.exact_residual import own_parts
from lcpflex.solvers.lcp.lemke import lemke_workspace
from lcpflex.solvers.lcp.pivoting import solve_active
from lcpflex.solvers.problem import Lcp, Solution

__all__ = ["REPAIRED", "repaired"]

REPAIRED = "exchanges row by row"
WRONG = 1e-14  # a sign counts as wrong beyond this fraction of the terms of its row
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones
LIMIT = 60  # solves
STEPS = 10  # of least change
RANK = 1e-14  # singular value of rows scaled by their terms, relative to the largest, below which they are redundant
LARGEST = 300  # unknowns up to which least changes are taken: a tenth of a second each

Flags = npt.NDArray[np.bool_]


def repaired(problem: Lcp, found: Solution, tolerance: float) -> Solution | None:
    """A better solution than ``found`` (which is none) by exchanges from its active set; None where there is none.

    Only of a point that is one as far as the problem as a whole is concerned: others need another method.
    """
    alike, units = problem.balanced()
    with np.errstate(all="ignore"):
        z = found.z if units is None else units.inward(found.z)
        if not natural_residual(*alike._data, z, len(z)) <= tolerance:
            return None
        best = found
        ways = [_exchanges(alike, z, found.active)]
        if problem.contacts is not None:
            ways.append(_least_changes(alike, z))
        for way in ways:
            for count, (point, active) in enumerate(way, 1):
                told = accept(
                    problem,
                    point if units is None else units.outward(point),
                    tolerance=tolerance,
                    iterations=count,
                    route=REPAIRED,
                    active=active.astype(np.int64),
                )
                if told.solved:
                    return told
                if told.residual < best.residual:
                    best = told
    return None if best is found else best


def _exchanges(problem: Lcp, z: FloatArray, active: IntArray | None) -> Iterator[tuple[FloatArray, Flags]]:
    """Points >= 0 with their sets, each after the exchange of what is wrong, from ``active`` or the set of z on."""
    basic = _set_of(problem, z) if active is None else active == 1
    fewest, patience, seen = len(z) + 1, PATIENCE, set()
    for _ in range(LIMIT):
        if basic.tobytes() in seen:
            return
        seen.add(basic.tobytes())
        basic, z, wrong = _solved(problem, basic)
        yield np.maximum(z, 0.0), basic
        if not wrong.any():
            return
        some = int(wrong.sum())
        fewest, patience = (some, PATIENCE) if some < fewest else (fewest, patience - 1)
        if patience < 0:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        basic = basic ^ wrong


def _least_changes(problem: Lcp, z: FloatArray) -> Iterator[tuple[FloatArray, Flags]]:
    """Points >= 0 with their sets, by steps of Newton's method that change z as little as they can."""
    M, q = problem._data
    for _ in range(STEPS if len(q) <= LARGEST else 0):
        basic = _set_of(problem, z)
        terms = np.abs(M) @ np.abs(z) + np.abs(q)
        z = np.where(basic, z, 0.0)
        rows = np.where(terms > 0.0, 1.0 / terms, 1.0)[basic]
        block, left = M[np.ix_(basic, basic)] * rows[:, None], (M @ z + q)[basic] * rows
        if not (np.isfinite(block).all() and np.isfinite(left).all()):
            return
        z[basic] -= np.linalg.lstsq(block, left, rcond=RANK)[0]
        yield np.maximum(z, 0.0), basic


def _set_of(problem: Lcp, z: FloatArray) -> Flags:
    """Which unknowns are basic at z, by the min-map."""
    M, q = problem._data
    rows = np.abs(M).max(axis=1, initial=0.0)
    basic: Flags = np.where(rows > 0.0, rows, 1.0) * z > M @ z + q
    return basic


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
