"""Nonsmooth Gauss-Seidel iteration for planar Coulomb friction, contact by contact.

The law of one contact, with the forces of all others held, is a problem in two unknowns,

    0 <= v_N = a p + b t + r_N  _|_  p >= 0,    v_T = c p + d t + r_T,    t in -mu p Sign(v_T),

solved exactly: open, sticking, or sliding one way or the other. It needs the Delassus matrix G, or its factor J alone:
then u = J^T lambda is kept up to date, a contact costs as much as its bodies have coordinates, and memory is linear in
the contacts. Since the last digits come slowly, the states found are taken as the active set of the whole problem from
time to time, which ends the iteration as soon as they are right.
Sources: Jean 1999 (nonsmooth contact dynamics); Jourdan, Alart & Jean 1998.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.errors import ModelError
from lcpflex.solvers.friction import ContactProblem, aligned
from lcpflex.solvers.lemke import lemke_workspace
from lcpflex.solvers.pivoting import block_pivots
from lcpflex.solvers.problem import Lcp, PosedProblem, Solution, Status, accept, check_limit, check_tolerance

__all__ = ["BlockGaussSeidel", "solve_contact", "sweep_delassus", "sweep_factor"]

OPEN, STICKING, FORTH, BACK = 0, 1, 2, 3  # state of a contact
ROUND = 1e-14  # how far a sign may be off, relative to its terms
SINGULAR = 1e-13  # relative determinant of a contact whose normal and tangent move together
FIRST_LOOK = 8  # sweeps before the first look at the residual; each time twice as many
EXCHANGES = 5  # of the active set in one attempt to finish
PIVOTING = 900  # unknowns up to which the attempt is made with dense matrices
CORRECTIONS = 6  # of the forces on fixed states
REGULAR = 1e-9  # of their equations, relative to the diagonal: redundant contacts make them singular
RUNAWAY = 1e14  # growth of the forces that ends the iteration
FAR = 1e3  # residual of a guess from which to start would only be to carry its rounding along


@kernel
def solve_contact(
    a: float, b: float, c: float, d: float, r_n: float, r_t: float, mu: float
) -> tuple[float, float, int]:
    """Forces p, t and state of one contact: v_N = a p + b t + r_N, v_T = c p + d t + r_T, |t| <= mu p.

    If no state fits (a Painleve pattern, a - mu |b| <= 0 while approaching), the forces that stop the approach without
    friction.
    """
    if r_n >= 0.0:
        return 0.0, 0.0, OPEN
    det = a * d - b * c
    if det > SINGULAR * a * d:
        p = (b * r_t - d * r_n) / det
        t = (c * r_n - a * r_t) / det
        if p >= 0.0 and abs(t) <= mu * p * (1.0 + ROUND):
            return p, min(max(t, -mu * p), mu * p), STICKING
    best, p_best, t_best, state = np.inf, 0.0, 0.0, FORTH
    for turn in range(2):
        sign = -1.0 if turn == 0 else 1.0  # of the friction force: against sliding forth, against sliding back
        stiffness = a + sign * mu * b
        if stiffness > SINGULAR * a:
            p = -r_n / stiffness
            slip = c * p + d * sign * mu * p + r_t
            wrong = sign * slip  # sliding forth has slip >= 0 and a negative force
            if wrong < best:
                best, p_best, t_best = wrong, p, sign * mu * p
                state = FORTH if turn == 0 else BACK
    if best < np.inf:
        return p_best, t_best, state
    return (-r_n / a if a > 0.0 else 0.0), 0.0, FORTH


@kernel
def _dot(row: FloatArray, x: FloatArray, n: int) -> float:
    """Sum of row_j x_j in four sums side by side."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    whole = n - n % 4
    for j in range(0, whole, 4):
        s0 += row[j] * x[j]
        s1 += row[j + 1] * x[j + 1]
        s2 += row[j + 2] * x[j + 2]
        s3 += row[j + 3] * x[j + 3]
    for j in range(whole, n):
        s0 += row[j] * x[j]
    return (s0 + s1) + (s2 + s3)


@kernel
def sweep_delassus(
    G: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    forces: FloatArray,
    states: IntArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """Up to ``sweeps`` sweeps on G (m, m); (how many were made, largest change of a contact velocity in the last one).

    free (m,), friction (n,); tangent_of (n,): tangential row of each contact, -1 without friction; forces (m,) and
    states (n,) are advanced in place. Ends early once the change is ``target`` or less.
    """
    m, n, change = len(free), len(friction), np.inf
    made = 0
    while made < sweeps and change > target:
        change = 0.0
        for k in range(n):
            row = G[k]
            p = forces[k]
            r_n = _dot(row, forces, m) + free[k] - row[k] * p
            t = tangent_of[k]
            if t < 0:
                new = max(0.0, -r_n / row[k]) if row[k] > 0.0 else 0.0
                states[k] = FORTH if new > 0.0 else OPEN
            else:
                side = G[t]
                q = forces[t]
                r_n -= row[t] * q
                r_t = _dot(side, forces, m) + free[t] - side[k] * p - side[t] * q
                new, rub, state = solve_contact(row[k], row[t], side[k], side[t], r_n, r_t, friction[k])
                states[k] = state
                change = max(change, abs(side[t] * (rub - q)))
                forces[t] = rub
            change = max(change, abs(row[k] * (new - p)))
            forces[k] = new
        made += 1
        if not change < np.inf:
            break
    return made, change


@kernel
def _row_dot(start: int, end: int, place: IntArray, value: FloatArray, u: FloatArray) -> float:
    total = 0.0
    for e in range(start, end):
        total += value[e] * u[place[e]]
    return total


@kernel
def _row_add(start: int, end: int, place: IntArray, value: FloatArray, factor: float, u: FloatArray) -> None:
    for e in range(start, end):
        u[place[e]] += factor * value[e]


@kernel
def sweep_factor(
    first: IntArray,
    place: IntArray,
    value: FloatArray,
    block: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    u: FloatArray,
    forces: FloatArray,
    states: IntArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """As :func:`sweep_delassus`, on the factor J with G = J J^T.

    first (m + 1,), place, value: the rows of J in compressed form; block (n, 3): G_NN, G_NT and G_TT of each contact;
    u (k,): J^T forces, kept up to date.
    """
    n, change = len(friction), np.inf
    made = 0
    while made < sweeps and change > target:
        change = 0.0
        for k in range(n):
            t = tangent_of[k]
            a, b, d = block[k, 0], block[k, 1], block[k, 2]
            p = forces[k]
            r_n = _row_dot(first[k], first[k + 1], place, value, u) + free[k] - a * p
            if t < 0:
                new = max(0.0, -r_n / a) if a > 0.0 else 0.0
                states[k] = FORTH if new > 0.0 else OPEN
            else:
                q = forces[t]
                r_n -= b * q
                r_t = _row_dot(first[t], first[t + 1], place, value, u) + free[t] - b * p - d * q
                new, rub, state = solve_contact(a, b, b, d, r_n, r_t, friction[k])
                states[k] = state
                change = max(change, abs(d * (rub - q)))
                if rub != q:
                    _row_add(first[t], first[t + 1], place, value, rub - q, u)
                    forces[t] = rub
            change = max(change, abs(a * (new - p)))
            if new != p:
                _row_add(first[k], first[k + 1], place, value, new - p, u)
                forces[k] = new
        made += 1
        if not change < np.inf:
            break
    return made, change


class _Iteration:
    """One run of the iteration: its forces and states, the two ways to sweep and the two ways to finish."""

    def __init__(self, problem: ContactProblem, guess: Solution | None, lcp: Lcp | None) -> None:
        self.problem = problem
        n = len(problem.friction)
        self.tangent_of = np.full(n, -1, dtype=np.int64)
        self.tangent_of[problem.tangent] = n + np.arange(len(problem.tangent))
        self.states = np.zeros(n, dtype=np.int64)
        self.forces = np.zeros(len(problem.free))
        self.dense = problem.delassus
        self.lcp = lcp
        if lcp is None and problem.delassus is not None and problem.size <= PIVOTING:
            self.lcp = problem.lcp()
        self.judge: Lcp | ContactProblem = problem if self.lcp is None else self.lcp
        start = aligned(guess, problem.unknown_keys)
        if start is not None and start.z.shape == (problem.size,):
            z = np.maximum(start.z, 0.0)
            if self.judge.residual(z) <= FAR:
                self.forces = np.concatenate(problem.forces(z))
        if self.dense is None:
            J = scipy.sparse.csr_array(problem.factor)
            self.J: Any = J
            self.rows = (J.indptr.astype(np.int64), J.indices.astype(np.int64), np.ascontiguousarray(J.data))
            self.block = _own_blocks(J, self.tangent_of)
            self.u = np.asarray(J.T @ self.forces)

    def sweep(self, sweeps: int, target: float) -> tuple[int, float]:
        """Up to so many sweeps; how many were made, and the largest change of a velocity in the last one."""
        problem = self.problem
        common = (problem.free, problem.friction, self.tangent_of)
        if self.dense is not None:
            return sweep_delassus(self.dense, *common, self.forces, self.states, sweeps, target)
        return sweep_factor(*self.rows, self.block, *common, self.u, self.forces, self.states, sweeps, target)

    def point(self) -> FloatArray:
        """z of the three-unknown form."""
        return self.problem.unknowns(*np.split(self.forces, [len(self.problem.friction)]))

    def basis(self) -> IntArray:
        """Which of [lambda_N, lambda_R, xi_L] are basic: those that the state leaves free to be positive."""
        tangent = self.problem.tangent
        states = self.states[tangent]
        slip = self.problem.velocity(self.forces)[len(self.problem.friction) :]
        leaving = (states == OPEN) & (slip < 0.0)  # xi_L carries the speed, and lambda_R = 0 pays for it
        right = (states == STICKING) | (states == BACK) | leaving
        left = (states == BACK) | leaving
        return np.concatenate([self.states != OPEN, right, left]).astype(np.int64)

    def finish(self) -> tuple[FloatArray, IntArray | None]:
        """z of the whole problem on the states as they are or little changed, and its basis if it is known."""
        if self.lcp is not None:
            z, basis = np.zeros(self.lcp.size), self.basis()
            table, work = lemke_workspace(self.lcp.size)
            work[: len(basis)] = basis
            if block_pivots(*self.lcp.data, self.lcp.size, z, table, work, EXCHANGES)[0] > 0:
                return z, work[: len(basis)].copy()
        return self._corrected(), None

    def _corrected(self) -> FloatArray:
        """z from the equations of the states, v_N = 0 where pressed and v_T = 0 where sticking; the shortest change."""
        problem, n = self.problem, len(self.problem.friction)
        pressed = np.flatnonzero(self.states != OPEN)
        sticking = pressed[(self.states[pressed] == STICKING) & (self.tangent_of[pressed] >= 0)]
        unknown = np.concatenate([pressed, self.tangent_of[sticking]])
        sign = np.select([self.states == FORTH, self.states == BACK], [-1.0, 1.0], 0.0) * problem.friction
        sliding = pressed[sign[pressed] != 0.0]
        entries = np.concatenate([np.ones(len(unknown)), sign[sliding]])
        rows = np.concatenate([unknown, self.tangent_of[sliding]])
        columns = np.concatenate([np.arange(len(unknown)), np.searchsorted(pressed, sliding)])
        spread = scipy.sparse.csr_array((entries, (rows, columns)), shape=(len(problem.free), len(unknown)))
        x = self.forces[unknown]
        if len(unknown):
            x = self._on_rows(unknown, spread, x)
        forces = spread @ x
        forces[:n] = np.maximum(forces[:n], 0.0)
        edge = (problem.friction * forces[:n])[problem.tangent]
        forces[n:] = np.clip(forces[n:], -edge, edge)
        return problem.unknowns(*np.split(forces, [n]))

    def _on_rows(self, unknown: IntArray, spread: Any, x: FloatArray) -> FloatArray:
        """x with (G spread x + free) = 0 on the rows ``unknown``, from a nearby x."""
        free = self.problem.free[unknown]
        if self.dense is not None:
            matrix = self.dense[unknown] @ spread
            for _ in range(2):  # the second takes out the rounding of the first
                x = x - np.linalg.lstsq(matrix, matrix @ x + free, rcond=1e-12)[0]
            return np.asarray(x)
        J, Jx = self.J[unknown], self.J.T @ spread
        weight = REGULAR * np.asarray(J.multiply(J).sum(axis=1)).ravel()
        k = self.J.shape[1]
        matrix = scipy.sparse.block_array(
            [[-scipy.sparse.eye_array(k), Jx], [J, scipy.sparse.diags_array(weight)]], format="csc"
        )
        solve = scipy.sparse.linalg.splu(matrix).solve
        for _ in range(CORRECTIONS):  # each takes out what the regularisation left in
            x = x + solve(np.concatenate([np.zeros(k), -(J @ (Jx @ x) + free)]))[k:]
        return np.asarray(x)


def _own_blocks(J: Any, tangent_of: IntArray) -> FloatArray:
    """G_NN, G_NT, G_TT of each contact by itself, (n, 3)."""
    n = len(tangent_of)
    squares = np.asarray(J.multiply(J).sum(axis=1)).ravel()
    block = np.zeros((n, 3))
    block[:, 0] = squares[:n]
    with_friction = np.flatnonzero(tangent_of >= 0)
    rows = tangent_of[with_friction]
    block[with_friction, 1] = np.asarray(J[with_friction].multiply(J[rows]).sum(axis=1)).ravel()
    block[with_friction, 2] = squares[rows]
    return block


@dataclass(frozen=True, slots=True)
class BlockGaussSeidel:
    """Gauss-Seidel iteration contact by contact, for many contacts with friction.

    tolerance: largest accepted residual [-]; sweep_limit: largest number of sweeps. Takes a :class:`ContactProblem`,
    with the Delassus matrix or only its factor, and an :class:`Lcp` that is symmetric, as contact without friction.
    Raises ModelError for numbers out of their range and for other problems. Converges in practice, without a guarantee.
    """

    tolerance: float = 1e-10
    sweep_limit: int = 20_000

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)
        check_limit("sweep_limit", self.sweep_limit)

    def refuses(self, problem: Lcp | PosedProblem) -> str:
        """Why the solver cannot take the problem; empty if it can."""
        if isinstance(problem, ContactProblem) or (problem if isinstance(problem, Lcp) else problem.lcp()).symmetric:
            return ""
        return (
            "an unsymmetric matrix does not tell which unknowns are one contact: expected a ContactProblem, or Lemke() "
            "or Auto() as the solver"
        )

    def solve(self, problem: Lcp | PosedProblem, guess: Solution | None = None) -> Solution:
        """Iterate, from the forces of the guess if there is one (matched by contact)."""
        if isinstance(problem, Lcp):
            if reason := self.refuses(problem):
                raise ModelError(reason)
            contacts = ContactProblem(problem.M, problem.q, np.zeros(problem.size))
            return self._iterate(_Iteration(contacts, guess, problem))
        if not isinstance(problem, ContactProblem):
            return problem.solve_by(self, guess)
        return replace(self._iterate(_Iteration(problem, guess, None)), keys=problem.unknown_keys)

    def _iterate(self, run: _Iteration) -> Solution:
        """Sweep, look, try to finish; each time after twice as many sweeps."""
        load = float(np.abs(run.problem.free).max(initial=0.0))
        target, look, sweeps = 0.1 * self.tolerance * load, FIRST_LOOK, 0
        best, least, active = np.zeros(run.problem.size), run.judge.residual(np.zeros(run.problem.size)), None
        route, status = "block Gauss-Seidel", Status.ITERATION_LIMIT
        while least > self.tolerance and sweeps < self.sweep_limit:
            made, change = run.sweep(min(look, self.sweep_limit) - sweeps, target)
            sweeps, look = sweeps + made, 2 * look
            if not change < RUNAWAY * load:
                status = Status.NUMERICAL_FAILURE
                break
            z = run.point()
            residual = run.judge.residual(z)
            if residual < least:
                best, least, active = z, residual, run.basis()
            if least <= self.tolerance:
                break
            z, basis = run.finish()
            residual = run.judge.residual(z)
            if residual < least:
                best, least, active = z, residual, basis
                if least <= self.tolerance:
                    route += ", finished on its active set"
            if change <= target:
                target *= 0.1
                if target < 1e-17 * load:
                    status = Status.NUMERICAL_FAILURE
                    break
        return accept(
            run.judge,
            best,
            tolerance=self.tolerance,
            status=status,
            iterations=sweeps,
            route=route,
            active=active,
        )
