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

from dataclasses import dataclass

import numpy as np

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.pivoting import block_pivots
from lcpflex.solvers.problem import (
    ITERATION_LIMIT,
    NUMERICAL_FAILURE,
    RAY,
    SOLVED,
    Lcp,
    PosedProblem,
    Solution,
    Status,
    accept,
    check_limit,
    check_tolerance,
)

__all__ = ["Lemke", "lemke", "lemke_workspace"]

GOLDEN = 0.6180339887498949
PIVOT = 1e-11  # smaller entries of the scaled tableau are rounding, never pivots
SLIP = 1e-13  # how far a basic variable may pass zero in favour of a larger pivot
GOOD = 1e-12  # residual that needs no repair
TARGET = 1e-10  # residual at which the ladder of retries ends
REPAIRS = 6  # exchanges allowed when the final basis is put right on the original data
RESTARTS = 3  # of one path, each with a perturbation far smaller than the last
ATTEMPTS = 8


def lemke_workspace(capacity: int) -> tuple[FloatArray, IntArray]:
    """Work arrays (table, basis) of :func:`lemke` for problems of up to ``capacity`` unknowns.

    table (capacity + 3, capacity + 3): the tableau, then three rows for the scaling, the candidate and the ray;
    basis (2 capacity + 1,): labels of the rows and columns of the tableau.
    """
    return np.zeros((capacity + 3, capacity + 3)), np.zeros(2 * capacity + 1, dtype=np.int64)


@kernel
def _scale(M: FloatArray, n: int, equilibrate: bool, table: FloatArray) -> None:
    """table[n, :n] = s such that the largest entry of each row and column of s_i M_ij s_j is near 1 (Ruiz)."""
    largest = 0.0
    for i in range(n):
        for j in range(i + 1):
            size = max(abs(M[i, j]), abs(M[j, i]))
            table[i, j] = size
            table[j, i] = size
            largest = max(largest, size)
    scale = table[n]
    start = 1.0 / np.sqrt(largest) if largest > 0.0 else 1.0
    for i in range(n):
        scale[i] = start
    if equilibrate:
        for _ in range(2):
            for i in range(n):
                row, peak = table[i], 0.0
                for j in range(n):
                    peak = max(peak, row[j] * scale[j])
                peak *= scale[i]
                if peak > 0.0:
                    scale[i] /= np.sqrt(peak)


@kernel
def _exchange(table: FloatArray, n: int, r: int, s: int) -> None:
    """Exchange the basic variable of row r with the nonbasic one of column s in x_B = b + T x_N.

    T is table[:n, :n + 1]; b, with and without perturbation, are the next two columns.
    """
    pivot_row = table[r]
    inverse = 1.0 / pivot_row[s]
    for j in range(n + 3):
        pivot_row[j] *= -inverse
    pivot_row[s] = inverse
    for i in range(n):
        row = table[i]
        factor = row[s]
        if i != r and factor != 0.0:
            row[s] = 0.0
            for j in range(n + 3):
                row[j] += factor * pivot_row[j]


@kernel
def _leaving_row(table: FloatArray, basis: IntArray, n: int, s: int) -> int:
    """Row whose variable first falls to zero as column s grows, -1 if none does.

    Two passes (Harris): the longest step that leaves every variable above -SLIP, then the largest pivot within that
    step; z0 wins every tie, for its leaving ends the path.
    """
    step = np.inf
    for i in range(n):
        slope = -table[i, s]
        if slope > PIVOT:
            step = min(step, (max(table[i, n + 1], 0.0) + SLIP) / slope)
    chosen, best = -1, 0.0
    if step < np.inf:
        for i in range(n):
            slope = -table[i, s]
            if slope > PIVOT and table[i, n + 1] <= step * slope:
                if basis[i] == 2 * n:
                    return i
                if slope > best:
                    chosen, best = i, slope
    return chosen


@kernel
def _path(
    M: FloatArray,
    q: FloatArray,
    n: int,
    table: FloatArray,
    basis: IntArray,
    attempt: int,
    perturbation: float,
    pivot_limit: int,
) -> tuple[int, int]:
    """Follow one almost complementary path; (status, pivots). The scaling is in table[n, :n].

    Out: the candidate z in table[n + 1, :n], the direction of a ray in table[n + 2, :n], basis[:n] = 1 where z is
    basic.
    """
    scale = table[n]
    load = 0.0
    for i in range(n):
        load = max(load, abs(q[i]) * scale[i])
    start, lowest = 0, np.inf
    for i in range(n):
        row = table[i]
        for j in range(n):
            row[j] = scale[i] * M[i, j] * scale[j]
        # Sequences k GOLDEN mod 1 are spread evenly and never repeat: no two perturbations or covers are equal.
        spread = ((i + 1) * GOLDEN * (attempt + 1)) % 1.0
        row[n] = 1.0 if attempt == 0 else 0.5 + ((i + 1) * GOLDEN * (attempt + 3)) % 1.0
        row[n + 2] = scale[i] * q[i] / load
        row[n + 1] = row[n + 2] + perturbation * (0.5 + spread)
        basis[i] = i  # w_i is labelled i, z_i n + i, z0 2n
        basis[n + i] = n + i
        if row[n + 1] / row[n] < lowest:
            start, lowest = i, row[n + 1] / row[n]
    basis[2 * n] = 2 * n
    status, pivots, s = _drive_out(table, basis, n, start, n, pivot_limit)
    for _ in range(RESTARTS):
        if status != SOLVED:
            break
        deepest, size = 0.0, 0.0
        for i in range(n):
            size = max(size, abs(table[i, n + 2]))
            deepest = max(deepest, -table[i, n + 2])
        if deepest <= SLIP * size:
            break
        # The perturbation was not small for this problem: go on from here, with one small beside what is missing.
        start, lowest = 0, np.inf
        for i in range(n):
            table[i, s] = 1.0
            table[i, n + 1] = table[i, n + 2] + deepest * perturbation * (0.5 + ((i + 1) * GOLDEN) % 1.0)
            if table[i, n + 1] < lowest:
                start, lowest = i, table[i, n + 1]
        status, more, s = _drive_out(table, basis, n, start, s, pivot_limit - pivots)
        pivots += more
        if status == RAY:
            status = NUMERICAL_FAILURE
    _read_off(table, basis, n, s, load, status)
    return status, pivots


@kernel
def _drive_out(table: FloatArray, basis: IntArray, n: int, r: int, s: int, pivot_limit: int) -> tuple[int, int, int]:
    """Complementary pivots from z0 in column s, entering in row r, until z0 leaves; (status, pivots, last column)."""
    pivots = 0
    while pivots < pivot_limit:
        _exchange(table, n, r, s)
        pivots += 1
        left = basis[r]
        basis[r], basis[n + s] = basis[n + s], left
        if left == 2 * n:
            return SOLVED, pivots, s
        partner = left + n if left < n else left - n
        s = 0
        while basis[n + s] != partner:
            s += 1
        r = _leaving_row(table, basis, n, s)
        if r < 0:
            return RAY, pivots, s
    return ITERATION_LIMIT, pivots, s


@kernel
def _read_off(table: FloatArray, basis: IntArray, n: int, s: int, load: float, status: int) -> None:
    """Candidate (and ray) from the final tableau, in the units of the original problem."""
    scale, candidate, ray = table[n], table[n + 1], table[n + 2]
    for i in range(n):
        candidate[i] = 0.0
        if status == RAY:
            ray[i] = 0.0
    for i in range(n):
        k = basis[i] - n
        if 0 <= k < n:
            candidate[k] = max(table[i, n + 2], 0.0) * load * scale[k]
            if status == RAY:
                ray[k] = max(table[i, s], 0.0) * scale[k]
    k = basis[n + s] - n
    if status == RAY and 0 <= k < n:
        ray[k] = scale[k]
    for i in range(n):
        basis[n + i] = 0  # labels of columns are not needed any more: collect the flags there
    for i in range(n):
        k = basis[i] - n
        if 0 <= k < n:
            # a label of a later row may sit where the flag goes, so flags are written to the second half first
            basis[n + k] = 1
    for i in range(n):
        basis[i] = basis[n + i]


@kernel
def lemke(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, table: FloatArray, basis: IntArray, pivot_limit: int
) -> tuple[int, int]:
    """Solve 0 <= z _|_ M z + q >= 0; returns (status, pivots), status as the integers of :class:`Status`.

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. Out: z (cap,),
    first n entries (the best point found if not solved). Work: table, basis of ``lemke_workspace(cap)``; afterwards
    basis[:n] is 1 where z is basic if solved, and table[n + 2, :n] the direction of the ray after RAY.
    pivot_limit: for each path. SOLVED here means a natural residual of 1e-10 or less.
    """
    trivial = True
    for i in range(n):
        z[i] = 0.0
        basis[i] = 0
        if not q[i] >= 0.0:
            trivial = False
    if trivial:
        return SOLVED, 0
    best, status, total = np.inf, ITERATION_LIMIT, 0
    candidate = table[n + 1]
    for attempt in range(ATTEMPTS):
        if attempt in (0, 2, 3):  # the scaling changes
            _scale(M, n, attempt != 2, table)
        perturbation = 1e-8
        if attempt in (1, 5):
            perturbation = 1e-6
        elif attempt in (3, 6):
            perturbation = 1e-4
        elif attempt == 4:
            perturbation = 1e-11
        ended, pivots = _path(M, q, n, table, basis, attempt, perturbation, pivot_limit)
        total += pivots
        residual = natural_residual(M, q, candidate, n)
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
            if block_pivots(M, q, n, candidate, table, basis, limit) > 0:
                residual = natural_residual(M, q, candidate, n)
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

    tolerance: largest accepted residual [-]. pivot_limit: pivots allowed on one path, None for 1000 + 50 n.
    Raises ModelError for a tolerance or limit that is not positive.
    """

    tolerance: float = 1e-10
    pivot_limit: int | None = None

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)
        check_limit("pivot_limit", self.pivot_limit)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Empty: Lemke's algorithm takes every problem."""
        return ""

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem. With the solution of a similar problem as guess, its basis is tried first."""
        if not isinstance(problem, Lcp):
            return problem.solve_by(self, guess)
        n = problem.size
        M, q = problem.data
        z = np.zeros(n)
        table, basis = lemke_workspace(n)
        if guess is not None and guess.active is not None and guess.active.shape == (n,):
            basis[:n] = guess.active
            solves = block_pivots(M, q, n, z, table, basis, REPAIRS)
            if solves > 0 and problem.residual(z) <= self.tolerance:
                return accept(
                    problem,
                    z,
                    tolerance=self.tolerance,
                    iterations=solves,
                    route="basis of the guess",
                    active=basis[:n].copy(),
                )
        limit = 1000 + 50 * n if self.pivot_limit is None else self.pivot_limit
        code, pivots = lemke(M, q, n, z, table, basis, limit)
        status = Status(code)
        return accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=status,
            iterations=pivots,
            route="lemke",
            active=basis[:n].copy() if status is Status.SOLVED else None,
            certificate=table[n + 2, :n].copy() if status is Status.RAY else None,
        )
