"""All solutions of a small problem, by trying every active set; and the proof that there is none.

For each of the 2^n sets A of basic unknowns, z_A = -M_AA^-1 q_A and z = 0 elsewhere solves the problem if z >= 0 and
w >= 0. If M_AA is singular and q_A lies outside its range, A gives nothing; if it lies inside, a linear program decides
whether the solutions of M_AA z_A = -q_A hold one with z >= 0 and w >= 0 (then usually a continuum of them). Where none
is found, the same is searched once more without rounding (:mod:`lcpflex.solvers.lcp.exact`), which proves that there is
none, or finds one. Source: Murty 1988, chapter 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.acceptance import accept
from lcpflex.solvers.arguments import check_guess, posed
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.lcp.active_factor import backward
from lcpflex.solvers.lcp.pivoting import eliminate, load_block
from lcpflex.solvers.lcp.proofs import exact_solution
from lcpflex.solvers.limits import keep_settings
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status
from lcpflex.solvers.refusals import no_cones

__all__ = ["LARGEST", "Enumeration", "enumerate_active_sets", "enumeration_workspace"]

LARGEST = 16  # unknowns: 65536 active sets
KEPT = 64  # solutions told apart
PROGRAMS = 64  # singular blocks for which a linear program is asked
SINGULAR = 1e-12  # pivot of rows and columns scaled to 1 below which a block is singular
OUTSIDE = 1e-9  # part of the right-hand side that is left over where it is outside of the range
NEGATIVE = 1e-11  # signs count as wrong beyond this part of the terms of w
APART = 1e-6  # relative distance of two solutions


def enumeration_workspace(capacity: int) -> tuple[FloatArray, IntArray]:
    """Work arrays (table, order) of :func:`enumerate_active_sets` for problems of up to ``capacity`` unknowns."""
    return np.zeros((capacity + 3, capacity + 1)), np.zeros(2 * capacity + 1, dtype=np.int64)


@kernel
def _load(M: FloatArray, q: FloatArray, n: int, code: int, table: FloatArray, order: IntArray) -> int:
    """The block M_AA with -q_A in the last column, rows and columns scaled to 1; its order. A is the bits of code.

    table[n + 2, i]: what the column of unknown i was multiplied by.
    """
    m = 0
    for i in range(n):
        if (code >> i) & 1:
            order[m] = i
            m += 1
    load_block(M, q, order, m, table)
    for c in range(m):
        largest = 0.0
        for k in range(m):
            largest = max(largest, abs(table[k, c]))
        lift = 1.0 / largest if largest > 0.0 else 1.0
        for k in range(m):
            table[k, c] *= lift
        table[n + 2, order[c]] = lift
    return m


@kernel
def _substitute(table: FloatArray, order: IntArray, m: int, n: int, z: FloatArray) -> None:
    x = table[n]
    for k in range(m):
        x[k] = table[k, m]
    backward(table, m, x)
    for i in range(n):
        z[i] = 0.0
    for k in range(m):
        z[order[k]] = x[k] * table[n + 2, order[k]]


@kernel
def _signs_hold(M: FloatArray, q: FloatArray, n: int, code: int, z: FloatArray) -> bool:
    """Whether z >= 0 and w >= 0 to rounding; what is negative within it becomes 0."""
    for i in range(n):
        w, terms, row = q[i], abs(q[i]), 0.0
        for j in range(n):
            w += M[i, j] * z[j]
            terms += abs(M[i, j] * z[j])
            row = max(row, abs(M[i, j]))
        sign = row * z[i] if (code >> i) & 1 else w
        if not sign >= -NEGATIVE * terms:
            return False
    for i in range(n):
        z[i] = max(z[i], 0.0)
    return True


@kernel
def enumerate_active_sets(
    M: FloatArray,
    q: FloatArray,
    n: int,
    tolerance: float,
    found: FloatArray,
    codes: IntArray,
    singular: IntArray,
    table: FloatArray,
    order: IntArray,
) -> tuple[int, int]:
    """Every solution with a nonsingular basis; (number of different ones, number of singular sets left undecided).

    M (cap, cap), q (cap,): the leading n x n block and first n entries count. Out: found (k, cap), the first k
    different solutions in the order of their active sets, counted as binary numbers with unknown 0 the lowest bit, and
    codes (k,), these numbers; singular (l,), the first l undecided ones. table, order: of
    ``enumeration_workspace(cap)``.
    """
    kept, undecided = 0, 0
    z = table[n + 1, :n]
    for code in range(1 << n):
        m = _load(M, q, n, code, table, order)
        rank = eliminate(table, order, m, True, SINGULAR)
        if rank < m:
            left, right = 0.0, 0.0
            for k in range(m):
                right = max(right, abs(table[k, m]))
                if k >= rank:
                    left = max(left, abs(table[k, m]))
            if left <= OUTSIDE * right:
                if undecided < len(singular):
                    singular[undecided] = code
                undecided += 1
            continue
        _substitute(table, order, m, n, z)
        if not _signs_hold(M, q, n, code, z) or not natural_residual(M, q, z, n) <= tolerance:
            continue
        new = True
        for k in range(min(kept, len(found))):
            far, size = 0.0, 0.0
            for i in range(n):
                far = max(far, abs(found[k, i] - z[i]))
                size = max(size, max(abs(z[i]), abs(found[k, i])))
            if far <= APART * size:
                new = False
                break
        if new:
            if kept < len(found):
                codes[kept] = code
                for i in range(n):
                    found[kept, i] = z[i]
            kept += 1
    return kept, undecided


@dataclass(frozen=True, slots=True)
class Enumeration:
    """All solutions of a problem of up to 16 unknowns.

    tolerance: largest accepted residual [-]. The statuses it can prove: NOT_UNIQUE, with the points in
    ``Solution.solutions`` (z is the first of them in the order of active sets as binary numbers, unknown 0 the lowest
    bit: the one with the fewest closed contacts of high number); NO_SOLUTION; INFEASIBLE with its vector. Raises
    ModelError for larger problems.
    """

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        keep_settings(self)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if reason := no_cones(self, problem):
            return reason
        size = problem.size if isinstance(problem, Lcp) else posed(problem).lcp().size
        if size <= LARGEST:
            return ""
        return f"the problem has {size} unknowns, 2^{size} active sets: enumeration goes up to {LARGEST}; use Auto()"

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Try every active set; a guess makes no difference.

        problem: an :class:`Lcp`, a :class:`ContactProblem` or another problem that is posed as one. guess: the
        solution of a similar problem to start from, or None.
        """
        if not isinstance(problem, Lcp):
            return posed(problem).solve_by(self, guess)
        check_guess(guess)
        if reason := self.refuses(problem):
            raise ModelError(reason)
        n = problem.size
        found, codes = np.zeros((KEPT, n)), np.zeros(KEPT, dtype=np.int64)
        singular = np.zeros(1 << n, dtype=np.int64)
        table, order = enumeration_workspace(n)
        kept, undecided = enumerate_active_sets(*problem._data, n, self.tolerance, found, codes, singular, table, order)
        points = [z.copy() for z in found[:kept]]
        programs = min(undecided, PROGRAMS)
        for code in singular[:programs].tolist():
            if out_of_time():
                break
            for z in _on_singular_block(problem, code, self.tolerance):
                if len(points) < KEPT and not any(_same(z, other) for other in points):
                    points.append(z)
        tried = 1 << n
        if not points:
            return self._without(problem, tried)
        active = None
        if kept:
            active = (int(codes[0]) >> np.arange(n)) & 1
        several = tuple(points) if len(points) > 1 else ()
        return accept(
            problem,
            points[0],
            tolerance=self.tolerance,
            iterations=tried,
            route="enumeration",
            active=active,
            solutions=several,
        )

    def _without(self, problem: Lcp, tried: int) -> Solution:
        """The result where floats give no solution: the proof that there is none, or what was left open."""
        late = out_of_time()
        proof, z = (None, None) if late else exact_solution(problem)
        message = ""
        if z is not None:
            message = "a solution exists, but rounded to floats it leaves more than the tolerance; z is it"
        elif proof is None and not late:
            message = "no active set gives a solution in floats, but the proof that none does was too much work"
        told = accept(
            problem,
            np.zeros(problem.size) if z is None else z,
            tolerance=self.tolerance,
            status=Status.TIME_LIMIT if late else Status.NUMERICAL_FAILURE,
            iterations=tried,
            route="enumeration",
            message=f"numerical failure: {message}" if message else "",
            proof=proof,
        )
        return replace(told, message="") if told.solved else told


def _same(z: FloatArray, other: FloatArray) -> bool:
    """Whether two points are one solution."""
    return bool(np.abs(z - other).max() <= APART * max(np.abs(z).max(), np.abs(other).max()))


def _on_singular_block(problem: Lcp, code: int, tolerance: float) -> list[FloatArray]:
    """Up to two solutions with z = 0 off the set ``code``, those with the least and with the largest sum of z."""
    M, q = problem._data
    n = len(q)
    on = ((code >> np.arange(n)) & 1).astype(bool)
    row = np.maximum(np.abs(M).max(axis=1), np.abs(q))
    row[row == 0.0] = 1.0
    A, b = M[:, on] / row[:, None], q / row
    bound = 1e3 * max(1.0, float(np.abs(b).max()))
    points = []
    for sign in (1.0, -1.0):
        try:
            program = libs.linprog(
                np.full(on.sum(), sign), A_ub=-A[~on], b_ub=b[~on], A_eq=A[on], b_eq=-b[on], bounds=(0.0, bound)
            )
        except (ValueError, RuntimeError, ArithmeticError):  # numbers too far apart for it; the exact search is not
            return []
        if program.x is None:
            return []
        z = np.zeros(n)
        z[on] = np.maximum(program.x, 0.0)
        if problem.residual(z) <= tolerance:
            points.append(z)
    return points
