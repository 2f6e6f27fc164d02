"""Lemke's algorithm on a condensed tableau.

    w = q + M z + c z0:   start with z0 large enough, drive it to zero by complementary pivots.

Guaranteed for P-matrices, and for copositive-plus ones (positive semidefinite included) where a ray means
that no solution exists; elsewhere it may end on a ray although solutions exist, and then says RAY. Three measures make
the textbook algorithm fit for floating point: the problem is scaled symmetrically; q carries a small
deterministic perturbation instead of a lexicographic order, with the unperturbed right-hand side as a second column, so
that a path of the perturbed problem ends in the solution of the true one; and what does not pass the
residual test is tried again with another perturbation, scaling and covering vector c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import is_called, listening
from lcpflex.solvers.certificate import judge
from lcpflex.solvers.clock import grown
from lcpflex.solvers.lcp.equilibration import equilibrate
from lcpflex.solvers.lcp.lexicographic import lexicographic_path
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.lcp.tableau import (
    CANDIDATE,
    COLUMNS,
    DIRECTION,
    EXTRA,
    ROWS,
    SCALE,
    SHIFTED,
    SLIP,
    TRUE,
    WAITING,
    enter,
    exchange,
    flush,
    leaving_row,
)
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import no_cones
from lcpflex.solvers.status import ITERATION_LIMIT, NUMERICAL_FAILURE, RAY, SOLVED, Status

__all__ = ["Lemke", "attempt", "lemke", "lemke_workspace", "pivot_budget"]

GOLDEN = 0.6180339887498949
GOOD = 1e-12  # residual that needs no repair
TARGET = 1e-10  # residual at which the ladder of retries ends
REPAIRS = 6  # exchanges allowed when the final basis is put right on the original data
RESTARTS = 3  # of one path, each with a perturbation far smaller than the last
ATTEMPTS = 26
BASIS = "basis of the guess"
FEW = 60  # unknowns up to which all attempts may take all their pivots
PATHS = 2  # beyond, so many times the pivots of one path end the ladder
LATE = 10  # attempts after which only those go on that ended near a solution, each with another cover
PERTURBATIONS = (1e-8, 1e-6, 1e-8, 1e-4, 1e-11, 1e-6, 1e-4, 1e-8, 1e-4)  # of q, relative, in the first attempts


def lemke_workspace(capacity: int) -> tuple[FloatArray, IntArray]:
    """Work arrays (table, basis) of :func:`lemke` for problems of up to ``capacity`` unknowns.

    table (capacity + 13, capacity + 1): the tableau, then the rows that ``tableau`` names;
    basis (4 capacity + 3,): labels of the rows and columns of the tableau, the columns of the labels, and whether a
    signal has come (:mod:`lcpflex.solvers.attention`).
    """
    return np.empty((capacity + EXTRA, capacity + 1)), np.zeros(4 * capacity + 3, dtype=np.int64)


@kernel
def _start(
    M: FloatArray, q: FloatArray, n: int, table: FloatArray, basis: IntArray, cover: int, size: float
) -> tuple[int, float]:
    """Fill the tableau with the scaled problem; the row in which z0 enters, -1 if |q| as scaled is no number, and that.

    Labels: w_i is i, z_i n + i, z0 2 n. cover: number of the vector c, ones for 0; size: of the perturbation, relative
    to |q|. The candidate, whose row the scaling has used, is zero.
    """
    scale, true, shifted, c = table[n + SCALE], table[n + TRUE], table[n + SHIFTED], table[n + COLUMNS]
    load = 0.0
    for i in range(n):
        load = max(load, abs(q[i]) * scale[i])
        table[n + CANDIDATE, i] = 0.0
    if not 0.0 < load < np.inf:
        return -1, load
    for i in range(n):
        row, source, factor = table[i], M[i], scale[i]
        for j in range(n):
            row[j] = factor * source[j] * scale[j]
        row[n] = 0.0
        true[i] = factor * q[i] / load
        shifted[i] = true[i] + size * (0.5 + _spread(i, cover + 1))
        c[i] = 1.0 if cover == 0 else 0.5 + _spread(i, cover + 3)
    for k in range(2 * n + 1):
        basis[k] = k
    for k in range(n + 1):
        basis[3 * n + 1 + k] = k  # column of the label n + k
    return _lowest(n, shifted, c), load


@kernel
def _spread(i: int, k: int) -> float:
    """Fraction in [0, 1): multiples of the golden ratio are spread evenly and never repeat."""
    value = (i + 1) * GOLDEN * k
    return value - math.floor(value)


@kernel
def _lowest(n: int, b: FloatArray, c: FloatArray) -> int:
    """Row that needs the largest z0 to become nonnegative."""
    chosen, lowest = 0, np.inf
    for i in range(n):
        if b[i] < lowest * c[i]:
            chosen, lowest = i, b[i] / c[i]
    return chosen


@kernel
def _path(
    table: FloatArray, basis: IntArray, n: int, r: int, perturbation: float, load: float, pivot_limit: int
) -> tuple[int, int]:
    """Complementary pivots from z0 in the last column, entering in row r, until z0 leaves; (status, pivots).

    Out: the candidate z and the direction of a ray in their rows of the table; basis[:n] = 1 where z is basic.
    """
    true, shifted = table[n + TRUE], table[n + SHIFTED]
    pivots, restarts, status, s, waiting = 0, 0, ITERATION_LIMIT, n, 0
    while pivots < pivot_limit and not is_called(basis):
        waiting = exchange(table, n, r, s, waiting)
        pivots += 1
        left = basis[r]
        basis[r], basis[n + s] = basis[n + s], left
        if left != 2 * n:
            if waiting == WAITING:
                flush(table, n)
                waiting -= WAITING
            basis[2 * n + 1 + left] = s
            s = basis[2 * n + 1 + (left + n if left < n else left - n)]
            enter(table, n, s, waiting)
            r = leaving_row(table, basis, n, waiting)
            if r < 0:
                status = RAY if restarts == 0 else NUMERICAL_FAILURE
                break
            continue
        deepest, size = 0.0, 0.0
        for i in range(n):
            size = max(size, abs(true[i]))
            deepest = max(deepest, -true[i])
        if deepest <= SLIP * size or restarts == RESTARTS:
            status = SOLVED
            break
        # The perturbation was not small for this problem: go on from here, with one small beside what is missing.
        restarts += 1
        for k in range(waiting, WAITING):
            for j in range(n + 1):
                table[n + COLUMNS + k, j] = 0.0
                table[n + ROWS + k, j] = 0.0
        flush(table, n)
        waiting -= waiting
        for i in range(n):
            table[i, s] = 0.0
            table[n + COLUMNS, i] = 1.0
            shifted[i] = true[i] + deepest * perturbation * (0.5 + _spread(i, restarts))
        r = _lowest(n, shifted, table[n + COLUMNS])
    _read_off(table, basis, n, s, waiting, load, status)
    return status, pivots


@kernel
def _read_off(table: FloatArray, basis: IntArray, n: int, s: int, waiting: int, load: float, status: int) -> None:
    """Candidate (and ray) from the final tableau, in the units of the original problem."""
    scale, candidate, ray = table[n + SCALE], table[n + CANDIDATE], table[n + DIRECTION]
    true, entered = table[n + TRUE], table[n + COLUMNS + waiting]
    for i in range(n):
        candidate[i] = 0.0
        ray[i] = 0.0
    for i in range(n):
        k = basis[i] - n
        if 0 <= k < n:
            candidate[k] = max(true[i], 0.0) * load * scale[k]
            if status == RAY:
                ray[k] = max(entered[i], 0.0) * scale[k]
    k = basis[n + s] - n
    if status == RAY and 0 <= k < n:
        ray[k] = scale[k]
    for i in range(n):
        basis[n + i] = 0  # labels below n are still to be read: the flags are collected behind them
    for i in range(n):
        if n <= basis[i] < 2 * n:
            basis[basis[i]] = 1
    for i in range(n):
        basis[i] = basis[n + i]


@kernel
def attempt(
    M: FloatArray, q: FloatArray, n: int, table: FloatArray, basis: IntArray, number: int, pivot_limit: int
) -> tuple[int, int, float]:
    """One path, with the scaling, perturbation and cover of that number; (status, pivots, residual of its end).

    M, q, n, table, basis, pivot_limit as of :func:`lemke`. Out: the candidate in table[n + CANDIDATE, :n], basis[:n].
    Attempt 0 must come first, and later ones in order, for most keep the scaling of the one before.
    """
    trivial = True
    for i in range(n):
        table[n + CANDIDATE, i] = 0.0
        basis[i] = 0
        if not q[i] >= 0.0:
            trivial = False
    if trivial:
        return SOLVED, 0, 0.0
    if number in (0, 1, 2, 3, 8) or number >= LATE:
        # None shows what scaling spoilt; many sweeps serve stacks with mass ratios near 1e8.
        sweeps = 0 if number == 2 else 10 if number == 8 else 2
        if number == 0 or number >= LATE:
            sweeps = (number + 1) % 2
        equilibrate(M, n, sweeps, table)
    perturbation = 1e-5 if number % 4 < 2 else 1e-4
    if number < len(PERTURBATIONS):
        perturbation = PERTURBATIONS[number]
    r, load = _start(M, q, n, table, basis, number, perturbation)
    if r < 0:
        return NUMERICAL_FAILURE, 0, np.inf
    status, pivots = _path(table, basis, n, r, perturbation, load, pivot_limit)
    return status, pivots, judge(M, q, table[n + CANDIDATE], n, table[n])


@kernel
def lexicographic_attempt(
    M: FloatArray, q: FloatArray, n: int, table: FloatArray, basis: IntArray, pivot_limit: int
) -> tuple[int, int, float]:
    """As :func:`attempt`, without a perturbation, ties broken lexicographically."""
    equilibrate(M, n, 2, table)
    r, load = _start(M, q, n, table, basis, 0, 0.0)
    if r < 0:
        return NUMERICAL_FAILURE, 0, np.inf
    status, pivots, s = lexicographic_path(table, basis, n, pivot_limit)
    _read_off(table, basis, n, s, 0, load, status)
    return status, pivots, judge(M, q, table[n + CANDIDATE], n, table[n])


@kernel
def pivot_budget(n: int) -> int:
    """Pivots that one path may take: what a path that ends needs, and no more where a pivot is dear."""
    return 1000 + 50 * n if n <= FEW else 1000 + 50 * FEW + 10 * (n - FEW)


@late_kernel
def lemke(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray, pivot_limit: int
) -> tuple[int, int]:
    """Solve 0 <= z _|_ M z + q >= 0; returns (status, pivots), status as the integers of :class:`Status`.

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. Out: z (cap,),
    first n entries (the best point found if not solved). Work: table, basis of ``lemke_workspace(cap)``; afterwards
    basis[:n] is 1 where z is basic if solved, and table[n + DIRECTION, :n] the direction of the ray after RAY.
    pivot_limit: for each path. SOLVED here means a natural residual of 1e-10 or less.
    """
    for i in range(n):
        z[i] = 0.0
    best, status, total = np.inf, ITERATION_LIMIT, 0
    candidate = table[n + CANDIDATE]
    for turn in range(ATTEMPTS + 1):
        number = max(turn - 1, 0)
        if (number >= LATE and status != NUMERICAL_FAILURE) or (n > FEW and total > PATHS * pivot_limit):
            break
        if is_called(basis):
            break
        if turn == 1:
            ended, pivots, residual = lexicographic_attempt(M, q, n, table, basis, pivot_limit)
        else:
            ended, pivots, residual = attempt(M, q, n, table, basis, number, pivot_limit)
        total += pivots
        if residual > GOOD and ended != RAY:
            # Repair from the basis where the path ended; from nothing if it hit the limit (Murty's matrices).
            if ended == ITERATION_LIMIT:
                for i in range(n):
                    basis[i] = 0
            limit = 10 * n + 20 if ended == ITERATION_LIMIT else REPAIRS
            if residual < best:
                best = residual
                for i in range(n):
                    z[i] = candidate[i]
            solves, repaired = block_pivots(M, q, n, candidate, table, basis, limit)
            if solves > 0:
                residual = repaired
        if residual < best:
            best = residual
            for i in range(n):
                z[i] = candidate[i]
        if best <= TARGET:
            return SOLVED, total
        if ended in (SOLVED, NUMERICAL_FAILURE):
            status = NUMERICAL_FAILURE
        elif ended == RAY and status != NUMERICAL_FAILURE:
            status = RAY
    return status, total


@dataclass(frozen=True, slots=True)
class Lemke:
    """Lemke's algorithm, for any matrix; the default solver of contact problems with friction.

    tolerance: largest accepted residual [-]. pivot_limit: pivots allowed on one path, None for 1000 + 50 n up to 60
    unknowns, and 10 more for each unknown beyond.
    Raises ModelError for a tolerance or limit that is not positive.
    """

    tolerance: float = 1e-10
    pivot_limit: int | None = None

    def __post_init__(self) -> None:
        keep_settings(self, "pivot_limit")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem, as those with cones; empty for all that are an LCP."""
        return no_cones(self, problem)

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem. With the solution of a similar problem as guess, its basis is tried first."""
        check_guess(guess)
        if not isinstance(problem, Lcp) or problem.balanced()[1] is not None:
            return posed(problem).solve_by(self, guess)
        n = problem.size
        M, q = problem._data
        table, basis = lemke_workspace(n)
        basis, ear = listening(basis, n)
        route = "lemke"
        if guess is not None and guess.active is not None and guess.active.shape == (n,):
            z = np.zeros(n)
            basis[:n] = guess.active == 1
            solves, residual = block_pivots(M, q, n, z, table, basis, REPAIRS)
            if solves > 0 and residual <= self.tolerance:
                active = basis[:n].copy()
                return accept(problem, z, tolerance=self.tolerance, iterations=solves, route=BASIS, active=active)
            route = f"{BASIS} (failed) > lemke"
        limit = pivot_budget(n) if self.pivot_limit is None else self.pivot_limit
        (code, pivots, residual), cut = grown(
            lambda most: attempt(M, q, n, table, basis, 0, most),
            limit,
            n,
            lambda found: found[0] == ITERATION_LIMIT,
            ear,
        )
        z = table[n + CANDIDATE, :n]
        if residual > GOOD and not cut:
            # Called by itself, for the ladder of attempts takes time to compile and is seldom needed.
            z = np.zeros(n)
            (code, pivots), cut = grown(
                lambda most: lemke(M, q, n, z, table, basis, most), limit, n, lambda found: found[0] != SOLVED, ear
            )
            if z[basis[:n] == 0].any():  # a last repair that made the point worse has left its basis
                basis[:n] = z > 0.0
        status = Status.SOLVED if residual <= GOOD or code == SOLVED else Status.TIME_LIMIT if cut else Status(code)
        found = accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=status,
            iterations=pivots,
            route=route,
            active=basis[:n].copy() if status is Status.SOLVED else None,
            certificate=table[n + DIRECTION, :n].copy() if status is Status.RAY else None,
        )
        if found.solved or status is not Status.SOLVED:
            return found
        from lcpflex.solvers.lcp.repairing import repaired  # which works in the memory of this module

        mended = repaired(problem, found, self.tolerance)
        return found if mended is None else replace(mended, route=f"{route} > {mended.route}", iterations=pivots)
