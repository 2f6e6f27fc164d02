"""The search of :mod:`.strategy` on contacts of a user: by compiled code where W is dense, else by factors of scipy.

With C = -dp/dv = U V of the units in their states, of which open ones and those that slide have few columns:

    blocks of W:   (I + C W) dx = -F,       by (I + V W U) u = V W (-F),   dx = -F - U u
    factor J:      (I + J^T C J) dx = -F
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, interpreted, kernel
from lcpflex.jit.struct import allocate, put_array
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact import alart_curnier, proximal_newton as newton, strategy, tracing
from lcpflex.solvers.contact.algebra import PLANAR, Vector
from lcpflex.solvers.contact.best import Best, copy_forces
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, measure_loads
from lcpflex.solvers.contact.matrices import equals_transpose
from lcpflex.solvers.contact.operators import Operator, product, unknowns
from lcpflex.solvers.contact.operators.blocks import Blocks
from lcpflex.solvers.contact.operators.dense import REGULAR, Dense
from lcpflex.solvers.contact.system import FEW, SIZES, ContactSystem

__all__ = ["UserSearch", "split_ranks", "user_attempts"]

FULL = 0.25  # of the entries of W: its factors have them all, and dense ones are then made three times as fast
RANK = 1e-12  # of the largest entry of a C_k: what is left is rounding
MARGIN = 0.1  # of the tolerance: what is judged is rounded once more, and contact by contact


Step = Callable[[FloatArray], FloatArray]


class _OutOfTime(Exception):
    """The solve that is under way has a limit of time, which has come."""


@kernel
def split_ranks(C: FloatArray, like: Vector, rest: FloatArray, left: FloatArray, right: FloatArray) -> int:
    """C_k = sum of a_r b_r^T over its rank, for blocks C (n, S S) by rows; how many such pairs there are.

    Out: left (n S, S + 1): a_r, and the number of its unit; right (n S, S): b_r. Work: rest (S S,).
    """
    S, count = len(like), 0
    for k in range(len(C)):
        first = 0.0
        for e in range(S * S):
            rest[e] = C[k, e]
            first = max(first, abs(rest[e]))
        for _ in range(S):
            most = 0
            for e in range(1, S * S):
                if abs(rest[e]) > abs(rest[most]):
                    most = e
            pivot, i, j = rest[most], most // S, most % S
            if not abs(pivot) > RANK * first:
                break
            for e in range(S):
                left[count, e], right[count, e] = rest[S * e + j] / pivot, rest[S * i + e]
            left[count, S] = k
            for a in range(S):
                for b in range(S):
                    rest[S * a + b] -= left[count, a] * right[count, b]
            count += 1
    return count


class _SparseFactors:
    """Factors of Newton's equations on one system, for what is interpreted."""

    def __init__(self, system: ContactSystem) -> None:
        self.system, self.n, self.rows = system, system.group.n, len(system.like)
        size = self.n * self.rows
        self.left, self.right = np.empty((size, self.rows + 1)), np.empty((size, self.rows))
        op = system.op
        if isinstance(op, Blocks):
            block = op.block.reshape(-1, self.rows, self.rows)
            W = libs.sparse.bsr_array((block, op.other, op.first), shape=(size, size))
            self.matrix: Any = libs.sparse.csr_array(W)
            op.symmetric = int(equals_transpose(self.matrix))
            if self.matrix.nnz > FULL * size**2:
                self.matrix = self.matrix.toarray()
        else:
            J = libs.sparse.csr_array((op.value, op.place, op.first), shape=(len(op.first) - 1, len(op.x)))
            present = op.row.ravel() >= 0
            places = np.flatnonzero(present), op.row.ravel()[present]
            spread = libs.sparse.csr_array((np.ones(len(places[0])), places), shape=(size, J.shape[0]))
            self.matrix = spread @ J

    def factorise(self, op: Operator, group: Group, C: FloatArray, like: Vector, shift: float = 0.0) -> bool:
        """As :func:`lcpflex.solvers.contact.operators.factorise`; shift: added to the diagonal of W."""
        if out_of_time():
            raise _OutOfTime
        S, size = self.rows, self.n * self.rows
        count = split_ranks(C, like, np.empty(S * S), self.left, self.right)
        if not np.isfinite(self.right[:count]).all():
            return False
        places = (S * self.left[:count, S, None].astype(np.int64) + np.arange(S)).ravel()
        pairs = np.repeat(np.arange(count), S)
        U = libs.sparse.csr_array((self.left[:count, :S].ravel(), (places, pairs)), shape=(size, count))
        V = libs.sparse.csr_array((self.right[:count].ravel(), (pairs, places)), shape=(count, size))
        try:
            if isinstance(op, Blocks):
                self.step = _through(V @ self.matrix + shift * V, U)
            else:
                J = self.matrix
                self.step = _factorised(libs.sparse.eye_array(J.shape[1]) + (J.T @ U) @ (V @ J))
        except RuntimeError:  # "Factor is exactly singular"
            return False
        return True

    def solve(self, op: Operator, group: Group, x: FloatArray) -> None:
        """As :func:`lcpflex.solvers.contact.operators.solve`."""
        n = unknowns(op, group)
        x[:n] = self.step(x[:n])

    def direction(self, op: Operator, group: Group, work: newton.NewtonWork, n: int, like: Vector) -> float:
        """As :func:`.proximal_newton.direction`."""
        work.step[:n] = -work.rest[:n]
        self.solve(op, group, work.step)
        return product(op, group, work.rest, work.step, like) if work.convex == 1 else 0.0

    def moving_direction(
        self, op: Operator, group: Group, work: newton.NewtonWork, p: FloatArray, like: Vector
    ) -> bool:
        """As :func:`.alart_curnier.direction`, of contacts in their units: I - C + C (W + a little)."""
        copy_forces(group, p, work.centre, like)
        newton.linearise(group, work, 1.0, like)
        work.factors += 1
        if not self.factorise(op, group, work.C, like, REGULAR - 1.0):
            return False
        self.direction(op, group, work, unknowns(op, group), like)
        return bool(np.isfinite(work.step).all())


def _through(VW: Any, U: Any) -> Step:
    """What solves (I + U V W) x = right side, by the factor of as many equations as U has columns."""
    if not U.shape[1]:
        return lambda x: x
    small = VW @ U
    full = isinstance(small, np.ndarray)
    solve = _dense_factors(small) if full else _factorised(libs.sparse.eye_array(U.shape[1]) + small)
    return lambda x: x - U @ solve(VW @ x)


def _dense_factors(small: FloatArray) -> Step:
    """What solves with I + ``small``, full. Raises RuntimeError where that is exactly singular."""
    matrix = np.eye(len(small)) + small
    factors, swaps, info = libs.linalg.lapack.dgetrf(matrix)
    if info != 0:
        raise RuntimeError("Factor is exactly singular")
    return lambda x: np.asarray(libs.linalg.lapack.dgetrs(factors, swaps, x)[0])


def _factorised(matrix: Any) -> Step:
    """What solves with a matrix whose diagonal is large: without exchanges of rows, in the order of least degree."""
    how: dict[str, Any] = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    solve: Step = libs.splu(libs.sparse.csc_array(matrix), **how).solve
    return solve


class UserSearch:
    """Attempts of a table on one system, in compiled code where W is dense, by factors of scipy else.

    Attributes
    ----------
    factors, sweeps
        How many there were so far.
    """

    def __init__(self, system: ContactSystem, tolerance: float, attempts: strategy.Attempts | None = None) -> None:
        """attempts: of the table; those of users by default."""
        self.attempts = user_attempts(len(system.like)) if attempts is None else attempts
        self.system, self.tolerance = system, tolerance
        self.factors = self.sweeps = 0
        op, group, rows = system.op, system.group, len(system.like)
        self.find: Any = strategy.find
        if isinstance(op, Dense):
            _make_room(op, group.n * rows)
        else:
            self.find = _interpreted(system)
        kept = _kept.memory.pop((group.n, rows), None) if isinstance(op, Dense) else None
        self.judged, self.best, self.work = _laid_out(op, group, rows) if kept is None else kept
        measure_loads(group, self.judged)
        self.search = strategy.search_for(self.attempts)

    def release(self) -> None:
        """Leave the memory of a few contacts to the next problem: this one is solved."""
        if isinstance(self.system.op, Dense) and self.system.group.n <= FEW:
            if len(_kept.memory) >= SIZES:
                _kept.memory.clear()
            sizes = self.system.group.n, len(self.system.like)
            _kept.memory[sizes] = self.judged, self.best, self.work

    @property
    def route(self) -> str:
        """What was tried, in words."""
        return strategy.route_names(self.search, self.attempts)

    def run(self, forces: FloatArray, factors: int, sweeps: int, keep: Callable[[FloatArray], bool]) -> None:
        """From forces (m,) on, then from none, with so many factors and sweeps at most.

        keep: takes the best forces (m,), whatever ends the search, and says whether they are good enough, as the
        certificate has it: contact by contact. Where they are not, but as a whole, the search goes on to rounding.
        """
        factors, sweeps = self.factors + factors, self.sweeps + sweeps
        for start in (forces, np.zeros(len(forces))) if forces.any() else (forces,):
            if self._is_found(start, factors, sweeps, keep) or self.factors >= factors or out_of_time():
                break

    def _is_found(self, forces: FloatArray, factors: int, sweeps: int, keep: Callable[[FloatArray], bool]) -> bool:
        """Until there were so many factors or sweeps in all."""
        judged, tolerance = self.judged, MARGIN * self.tolerance
        for goal in (tolerance, min(tolerance, strategy.SETTLED)):
            judged.tolerance = goal
            try:
                self._find(forces, factors - self.factors, sweeps - self.sweeps)
            finally:
                forces = self.system.by_rows(self.best.p)
                done = keep(forces)
            if done:
                return True
            if not self.best.worst <= tolerance * judged.load:
                break
        return False

    def _find(self, forces: FloatArray, factors: int, sweeps: int) -> None:
        system, search, work = self.system, self.search, self.work
        system.take(forces)
        search.factor_limit, search.sweep_limit, work.factors, search.sweeps = factors, sweeps, 0, 0
        try:
            self.find(system.op, system.group, self.judged, self.best, work, search, self.attempts, system.like)
        except _OutOfTime:
            pass
        finally:
            self.factors += work.factors
            self.sweeps += search.sweeps


Memory = tuple[Judged, Best, newton.NewtonWork]


class _Kept(threading.local):
    """Memory of a few contacts, one of each size: to lay it out takes as long as to solve them."""

    def __init__(self) -> None:
        self.memory: dict[tuple[int, int], Memory] = {}


_kept = _Kept()


@cache
def user_attempts(rows: int, table: tuple[strategy.Attempt, ...] = strategy.USER_CONTACTS) -> strategy.Attempts:
    """The rows of a table that are for problems of S = ``rows``, made once."""
    return strategy.attempts_for(rows, table)


def _laid_out(op: Operator, group: Group, rows: int) -> Memory:
    """Memory of a search: what is judged, the best point, and that of Newton's method."""
    sizes = {"units": group.n, "rows": rows, "block": rows * rows, "unknowns": unknowns(op, group)}
    return allocate(Judged, {}), allocate(Best, sizes), allocate(newton.NewtonWork, sizes)


def _make_room(op: Dense, size: int) -> None:
    """For factors of dense contacts, in which W is looked at."""
    op.symmetric = int(equals_transpose(op.columns))
    if len(op.table) != size:
        put_array(op, "table", np.zeros((size, size)))
        put_array(op, "pivots", np.zeros(size, dtype=np.int64))
        put_array(op, "solution", np.zeros(size))


def _interpreted(system: ContactSystem) -> Any:
    """The search with its loops in Python, since its factors are."""
    own = _SparseFactors(system)
    inner = interpreted(newton.solve_inner, factorise=own.factorise, direction=own.direction)
    method = interpreted(newton.proximal_newton, solve_inner=inner)
    path: Any = tracing.no_path
    if system.like is PLANAR:
        turned = interpreted(tracing.direction, solve=own.solve)
        corrected = interpreted(tracing.correct, solve=own.solve)
        path = interpreted(tracing.trace_in_plane, factorise=own.factorise, direction=turned, correct=corrected)
    paths = interpreted(strategy.follow_paths, trace=path, proximal_newton=method)
    convex = interpreted(newton.convex_start, solve_inner=inner)
    moving = interpreted(alart_curnier.alart_curnier, direction=own.moving_direction)
    own_ways = {"proximal_newton": method, "convex_start": convex, "follow_paths": paths, "alart_curnier": moving}
    one = interpreted(strategy.try_one, **own_ways)
    is_for = interpreted(strategy.is_for, moves_centre=lambda op: isinstance(op, Blocks))
    return interpreted(strategy.find, try_one=one, is_for=is_for)
