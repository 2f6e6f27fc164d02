"""Principal pivoting for symmetric positive semidefinite problems, on a Cholesky factor that is kept up to date.

    z_A = -M_AA^{-1} q_A,   w_N = q_N + M_NA z_A:   exchange indices of a wrong sign between A and N until none is left

Two phases share one factor. *Block exchanges* (Kostreva 1978; Judice & Pires 1994) move all wrong signs at once: mostly
three to five solves, but they may run in circles. When the number of wrong signs stops falling, *single exchanges*
(Dantzig & Cottle 1967; Keller 1973) take over: z >= 0 is kept, 1/2 z.M z + q.z falls with each exchange, and the method
ends for every semidefinite M. An index r whose column depends on those of A enters only in exchange for another one;
where none blocks its increase, the direction

    u_r = 1,  u_A = -M_AA^{-1} M_Ar,   M u = 0,  u >= 0,  q.u = w_r < 0

is Farkas' proof that there is no solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.attention import is_called, listening
from lcpflex.solvers.certificate import judge
from lcpflex.solvers.clock import grown
from lcpflex.solvers.lcp.active_factor import backward, factorise, forward, join, leave, new_column
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution
from lcpflex.solvers.refusals import no_cones
from lcpflex.solvers.status import ITERATION_LIMIT, NUMERICAL_FAILURE, RAY, SOLVED, Status

__all__ = [
    "PrincipalPivoting",
    "block_exchanges",
    "principal_pivoting",
    "principal_pivoting_workspace",
    "single_exchanges",
]

WRONG = 1e-14  # a sign counts as wrong beyond this fraction of the terms it is made of
SLIP = 1e-14  # how far a variable may pass zero in favour of a larger entry of the direction, relative to all
PATIENCE = 3  # block exchanges without fewer wrong signs before single ones
UPDATES = 6  # a factor of order m is updated for up to m / UPDATES exchanges, else computed anew


def principal_pivoting_workspace(capacity: int) -> tuple[FloatArray, IntArray]:
    """Work arrays (factor, basis) of :func:`principal_pivoting` for problems of up to ``capacity`` unknowns.

    factor (capacity + 5, capacity): the rows of R, then the square roots of the diagonal, w, and three vectors;
    basis (3 capacity + 1,): which z are basic, the order in which they stand in R, which signs are wrong, and whether a
    signal has come (:mod:`lcpflex.solvers.attention`).
    """
    return np.empty((capacity + 5, capacity)), np.zeros(3 * capacity + 1, dtype=np.int64)


@kernel
def _solve_active(M: FloatArray, q: FloatArray, n: int, z: FloatArray, R: FloatArray, basis: IntArray, m: int) -> float:
    """z_A from R and w of all indices in R[n + 1]; returns sum_A sqrt(M_jj) |z_j|, which bounds the terms of w."""
    root, w, x = R[n], R[n + 1], R[n + 2]
    for j in range(m):
        x[j] = -q[basis[n + j]]
    forward(R, m, x)
    backward(R, m, x)
    for i in range(n):
        z[i] = 0.0
    size = 0.0
    for j in range(m):
        i = basis[n + j]
        z[i] = x[j]
        size += root[i] * abs(x[j])
    _slack(M, q, n, z, basis, m, w)
    return size


@kernel
def _slack(M: FloatArray, q: FloatArray, n: int, z: FloatArray, basis: IntArray, m: int, w: FloatArray) -> None:
    """w = q + M z for a z that is zero outside of A; rows of M serve as columns."""
    for i in range(n):
        w[i] = q[i]
    for p in range(0, m, 4):
        a, b = basis[n + p], basis[n + min(p + 1, m - 1)]
        c, d = basis[n + min(p + 2, m - 1)], basis[n + min(p + 3, m - 1)]
        zb = z[b] if p + 1 < m else 0.0
        zc = z[c] if p + 2 < m else 0.0
        zd = z[d] if p + 3 < m else 0.0
        za, ra, rb, rc, rd = z[a], M[a], M[b], M[c], M[d]
        for i in range(n):
            w[i] += (za * ra[i] + zb * rb[i]) + (zc * rc[i] + zd * rd[i])


@kernel
def _mark_wrong(q: FloatArray, n: int, z: FloatArray, R: FloatArray, basis: IntArray, size: float, singly: bool) -> int:
    """basis[2n + i] = 1 where z_i of A or (unless singly) w_i of the rest is negative beyond rounding; how many."""
    root, w = R[n], R[n + 1]
    wrong = 0
    for i in range(n):
        if basis[i] == 1:
            right = root[i] * z[i] >= -WRONG * size
        else:
            right = singly or w[i] >= -WRONG * (abs(q[i]) + root[i] * size)
        basis[2 * n + i] = 0 if right else 1
        wrong += basis[2 * n + i]
    return wrong


@kernel
def _exchange(M: FloatArray, n: int, R: FloatArray, basis: IntArray, m: int) -> int:
    """Exchange all marked indices; returns the new order of R. With m = 0 the factor is computed anew."""
    wrong = 0
    for i in range(n):
        wrong += basis[2 * n + i]
    if wrong * UPDATES >= m:
        for i in range(n):
            if basis[2 * n + i] == 1:
                basis[i] = 1 - basis[i]
        return factorise(M, n, R, basis)
    y = R[n + 3]
    for p in range(m - 1, -1, -1):
        if basis[2 * n + basis[n + p]] == 1:
            basis[2 * n + basis[n + p]] = 0
            leave(n, R, basis, m, p, y)
            m -= 1
    for r in range(n):
        if basis[2 * n + r] == 1:
            pivot = new_column(M, n, R, basis, m, r, y)
            if pivot > 0.0:
                join(n, R, basis, m, r, y, pivot)
                m += 1
    return m


@kernel
def _most_wrong(q: FloatArray, n: int, R: FloatArray, basis: IntArray, size: float) -> int:
    """The index outside of A with the most negative w / sqrt(M_ii), -1 if all are right."""
    root, w = R[n], R[n + 1]
    chosen, deepest = -1, 0.0
    for i in range(n):
        if basis[i] == 0 and w[i] < -WRONG * (abs(q[i]) + root[i] * size):
            depth = -w[i] / root[i] if root[i] > 0.0 else np.inf
            if depth > deepest:
                chosen, deepest = i, depth
    return chosen


@kernel
def _first_to_vanish(n: int, z: FloatArray, R: FloatArray, basis: IntArray, m: int) -> tuple[int, float]:
    """Place in A of the variable that first falls to zero along -R[n + 4], and the step; (-1, inf) if none does.

    Two passes (Harris): the longest step that leaves all above zero but for rounding, then the fastest to fall.
    """
    root, x = R[n], R[n + 4]
    all_x, all_z = 0.0, 0.0
    for j in range(m):
        i = basis[n + j]
        all_x = max(all_x, root[i] * abs(x[j]))
        all_z = max(all_z, root[i] * abs(z[i]))
    step = np.inf
    for j in range(m):
        i = basis[n + j]
        slope = root[i] * x[j]
        if slope > SLIP * all_x:
            step = min(step, (root[i] * max(z[i], 0.0) + SLIP * all_z) / slope)
    chosen, fastest, length = -1, 0.0, np.inf
    for j in range(m):
        i = basis[n + j]
        slope = root[i] * x[j]
        if slope > SLIP * all_x and slope > fastest and root[i] * max(z[i], 0.0) <= step * slope:
            chosen, fastest, length = j, slope, max(z[i], 0.0) / x[j]
    return chosen, length


@kernel
def _write_ray(n: int, R: FloatArray, basis: IntArray, m: int, r: int) -> None:
    """R[n + 2, :n] = u with u_r = 1, u_A = -R[n + 4]."""
    ray, x = R[n + 2], R[n + 4]
    for i in range(n):
        ray[i] = 0.0
    ray[r] = 1.0
    for j in range(m):
        ray[basis[n + j]] = max(-x[j], 0.0)


@kernel
def _raise(
    M: FloatArray, n: int, z: FloatArray, R: FloatArray, basis: IntArray, m: int, r: int, limit: int
) -> tuple[int, int, int]:
    """Let z_r grow until w_r = 0, taking out of A what falls to zero on the way; (status, order of R, exchanges).

    z_A falls along x = M_AA^{-1} M_Ar. After RAY, R[n + 2, :n] is the direction along which q.z falls without end.
    """
    x, y, slack = R[n + 4], R[n + 3], R[n + 1, r]
    for count in range(limit):
        if is_called(basis):
            break
        pivot = new_column(M, n, R, basis, m, r, y)
        for j in range(m):
            x[j] = y[j]
        backward(R, m, x)
        place, step = _first_to_vanish(n, z, R, basis, m)
        if pivot > 0.0 and -slack <= step * pivot:
            join(n, R, basis, m, r, y, pivot)
            return SOLVED, m + 1, count + 1
        if place < 0:
            _write_ray(n, R, basis, m, r)
            return RAY if pivot <= 0.0 else NUMERICAL_FAILURE, m, count
        for j in range(m):
            z[basis[n + j]] -= step * x[j]
        z[r] += step
        slack += step * pivot
        z[basis[n + place]] = 0.0
        leave(n, R, basis, m, place, y)
        m -= 1
    return ITERATION_LIMIT, m, limit


@kernel
def _finish(
    M: FloatArray, q: FloatArray, n: int, z: FloatArray, R: FloatArray, basis: IntArray, m: int, tolerance: float
) -> bool:
    """Cut what is negative by rounding; refine z once, by w as the certificate sees it, if the residual asks for it."""
    x, w = R[n + 2], R[n + 1]
    for refined in range(2):
        for j in range(m):
            i = basis[n + j]
            z[i] = max(z[i], 0.0)
        if judge(M, q, z, n, w) <= tolerance:
            return True
        if refined == 0:
            for j in range(m):
                x[j] = w[basis[n + j]]
            forward(R, m, x)
            backward(R, m, x)
            for j in range(m):
                z[basis[n + j]] -= x[j]
    return False


@kernel
def block_exchanges(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    factor: FloatArray,
    basis: IntArray,
    warm: bool,
    tolerance: float,
    pivot_limit: int,
) -> tuple[int, int]:
    """The first phase, which solves nearly all problems by itself; arguments as of :func:`principal_pivoting`.

    The status is SOLVED, NUMERICAL_FAILURE if signs are right but the residual is not, else ITERATION_LIMIT.
    """
    root = factor[n]
    for i in range(n):
        root[i] = np.sqrt(max(M[i, i], 0.0))
        basis[2 * n + i] = 0
        if not warm:
            basis[i] = 1 if q[i] < 0.0 else 0
    fewest, patience, pivots = n + 1, PATIENCE, 0
    m, singly = 0, False
    while pivots < pivot_limit and patience >= 0 and not is_called(basis):
        m = _exchange(M, n, factor, basis, m)
        size = _solve_active(M, q, n, z, factor, basis, m)
        pivots += 1
        wrong = _mark_wrong(q, n, z, factor, basis, size, singly)
        if wrong == 0:
            return SOLVED if _finish(M, q, n, z, factor, basis, m, tolerance) else NUMERICAL_FAILURE, pivots
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(wrong, fewest)
    return ITERATION_LIMIT, pivots


@late_kernel
def single_exchanges(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    factor: FloatArray,
    basis: IntArray,
    tolerance: float,
    pivot_limit: int,
) -> tuple[int, int]:
    """The second phase, from where the first one ended; arguments as of :func:`principal_pivoting`."""
    for i in range(n):
        basis[2 * n + i] = 0
    m, singly, pivots = 0, True, 0
    while pivots < pivot_limit and not is_called(basis):
        m = _exchange(M, n, factor, basis, m)
        size = _solve_active(M, q, n, z, factor, basis, m)
        pivots += 1
        if _mark_wrong(q, n, z, factor, basis, size, singly) > 0:
            continue
        r = _most_wrong(q, n, factor, basis, size)
        if r < 0:
            return SOLVED if _finish(M, q, n, z, factor, basis, m, tolerance) else NUMERICAL_FAILURE, pivots
        status, m, more = _raise(M, n, z, factor, basis, m, r, pivot_limit - pivots)
        pivots += more
        if status != SOLVED:
            return status, pivots
    return ITERATION_LIMIT, pivots


@kernel
def principal_pivoting(
    M: FloatArray,
    q: FloatArray,
    n: int,
    z: FloatArray,
    factor: FloatArray,
    basis: IntArray,
    warm: bool,
    tolerance: float,
    pivot_limit: int,
) -> tuple[int, int]:
    """Solve 0 <= z _|_ M z + q >= 0 with M symmetric positive semidefinite; returns (status, pivots).

    M (cap, cap) and q (cap,): the leading n x n block and first n entries count and are not changed. Out: z (cap,),
    first n entries (the last point if not solved). Work: factor, basis of ``principal_pivoting_workspace(cap)``; in:
    basis[:n] is 1 where z is basic in a similar problem, if ``warm``; out: the same of this one. After the status RAY,
    factor[n + 2, :n] is the direction of the ray. A solve on one active set or a single exchange counts as a pivot;
    SOLVED means a natural residual of ``tolerance`` or less.
    """
    status, pivots = block_exchanges(M, q, n, z, factor, basis, warm, tolerance, pivot_limit)
    if status == SOLVED:
        return status, pivots
    status, more = single_exchanges(M, q, n, z, factor, basis, tolerance, pivot_limit - pivots)
    return status, pivots + more


@dataclass(frozen=True, slots=True)
class PrincipalPivoting:
    """Principal pivoting, for symmetric positive semidefinite matrices; the fastest solver of contact without friction.

    tolerance: largest accepted residual [-]. pivot_limit: pivots allowed, None for 100 + 20 n. For an indefinite
    symmetric matrix there is no guarantee, only an honest status. Raises ModelError for a tolerance or limit that is
    not positive.
    """

    tolerance: float = 1e-10
    pivot_limit: int | None = None

    def __post_init__(self) -> None:
        keep_settings(self, "pivot_limit")

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the problem cannot be taken: its matrix is not symmetric."""
        if reason := no_cones(self, problem):
            return reason
        lcp = problem if isinstance(problem, Lcp) else posed(problem).lcp()
        return "" if lcp.symmetric else "M is not symmetric: principal pivoting needs M = M^T, Lemke takes every matrix"

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Solve the problem. With the solution of a similar problem as guess, its basis is the first one tried.

        Raises ModelError if M is not symmetric.
        """
        check_guess(guess)
        if not isinstance(problem, Lcp) or problem.balanced()[1] is not None:
            return posed(problem).solve_by(self, guess)
        if not problem.symmetric:
            raise ModelError(self.refuses(problem))
        n = problem.size
        M, q = problem._data
        z = np.zeros(n)
        factor, basis = principal_pivoting_workspace(n)
        warm = False
        if guess is not None and guess.active is not None and guess.active.shape == (n,):
            basis[:n] = guess.active == 1
            warm = True
        limit = 100 + 20 * n if self.pivot_limit is None else self.pivot_limit
        basis, ear = listening(basis, n)
        start = basis[:-1].copy()

        def exchanged(most: int) -> tuple[int, int]:
            basis[:-1] = start
            code, pivots = block_exchanges(M, q, n, z, factor, basis, warm, self.tolerance, most)
            if code == SOLVED:
                return code, pivots
            # Called by itself, for it takes time to compile and is seldom needed.
            code, more = single_exchanges(M, q, n, z, factor, basis, self.tolerance, most - pivots)
            return code, pivots + more

        (code, pivots), cut = grown(exchanged, limit, n, lambda found: found[0] == ITERATION_LIMIT, ear)
        return accept(
            problem,
            z,
            tolerance=self.tolerance,
            status=Status.TIME_LIMIT if cut else Status(code),
            iterations=pivots,
            route="principal pivoting",
            active=basis[:n].copy() if code == SOLVED else None,
            certificate=factor[n + 2, :n].copy() if code == RAY else None,
        )
