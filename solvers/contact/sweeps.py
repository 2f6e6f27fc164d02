"""Sweeps over planar contacts with Coulomb friction: the compiled part of the block Gauss-Seidel iteration.

The law of one contact, with the forces of all others held, is a problem in two unknowns,

    0 <= v_N = a p + b t + r_N  _|_  p >= 0,    v_T = c p + d t + r_T,    t in -mu p Sign(v_T),

solved exactly: open, sticking, or sliding one way or the other. Sources: Jean 1999; Jourdan, Alart & Jean 1998.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.attention import is_called
from lcpflex.solvers.certificate import judge
from lcpflex.solvers.contact.laws.interval import solve_contact
from lcpflex.solvers.contact.laws.states import BACK, FORTH, OPEN, STICKING
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.semidefinite import dot
from lcpflex.solvers.status import ITERATION_LIMIT, NUMERICAL_FAILURE, SOLVED

__all__ = ["block_gauss_seidel", "sweep_blocks", "sweep_delassus", "sweep_factor", "take_basis"]

FIRST_LOOK = 8  # sweeps before the first look at the residual; each time twice as many
EXCHANGES = 5  # of the active set in one attempt to finish
RUNAWAY = 1e14  # growth of the forces that ends the iteration
LAST_DIGIT = 1e-17  # change of a contact velocity, relative to the free one, below which no sweep changes anything


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
            r_n = dot(row, forces, 0, m) + free[k] - row[k] * p
            t = tangent_of[k]
            if t < 0:
                new = max(0.0, -r_n / row[k]) if row[k] > 0.0 else 0.0
                states[k] = FORTH if new > 0.0 else OPEN
            else:
                side = G[t]
                q = forces[t]
                r_n -= row[t] * q
                r_t = dot(side, forces, 0, m) + free[t] - side[k] * p - side[t] * q
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


@kernel
def sweep_blocks(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    own: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    forces: FloatArray,
    states: IntArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """As :func:`sweep_delassus`, on the blocks of a :class:`lcpflex.solvers.contact.coupling.Coupling`."""
    n, change = len(friction), np.inf
    made = 0
    while made < sweeps and change > target:
        change = 0.0
        for k in range(n):
            t = tangent_of[k]
            r_n, r_t = free[k], 0.0
            for e in range(first[k], first[k + 1]):
                c = other[e]
                if c != k:
                    p, j = forces[c], tangent_of[c]
                    q = forces[j] if j >= 0 else 0.0
                    r_n += block[e, 0] * p + block[e, 1] * q
                    r_t += block[e, 2] * p + block[e, 3] * q
            a, d = own[k, 0], own[k, 3]
            if t < 0:
                new = max(0.0, -r_n / a) if a > 0.0 else 0.0
                states[k] = FORTH if new > 0.0 else OPEN
            else:
                r_t += free[t]
                new, rub, state = solve_contact(a, own[k, 1], own[k, 2], d, r_n, r_t, friction[k])
                states[k] = state
                change = max(change, abs(d * (rub - forces[t])))
                forces[t] = rub
            change = max(change, abs(a * (new - forces[k])))
            forces[k] = new
        made += 1
        if not change < np.inf:
            break
    return made, change


@kernel
def _take_point(
    G: FloatArray, free: FloatArray, friction: FloatArray, tangent_of: IntArray, forces: FloatArray, z: FloatArray
) -> None:
    """z = [lambda_N, lambda_R, xi_L] of the three-unknown form for the forces [lambda_N, lambda_T] as they are."""
    m, n = len(free), len(friction)
    for k in range(n):
        z[k] = forces[k]
        t = tangent_of[k]
        if t >= 0:
            z[t] = forces[t] + friction[k] * forces[k]
            z[m - n + t] = max(-dot(G[t], forces, 0, m) - free[t], 0.0)


@kernel
def take_basis(states: IntArray, tangent_of: IntArray, m: int, z: FloatArray, basis: IntArray) -> None:
    """basis[:n] = 1 for those of [lambda_N, lambda_R, xi_L] that the states leave free to be positive."""
    n = len(states)
    for k in range(n):
        state, t = states[k], tangent_of[k]
        basis[k] = 0 if state == OPEN else 1
        if t >= 0:
            left = m - n + t
            leaving = state == OPEN and z[left] > 0.0  # xi_L carries the speed, and lambda_R = 0 pays for it
            basis[t] = 1 if state in (STICKING, BACK) or leaving else 0
            basis[left] = 1 if state == BACK or leaving else 0


@kernel
def block_gauss_seidel(
    G: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    M: FloatArray,
    q: FloatArray,
    forces: FloatArray,
    states: IntArray,
    z: FloatArray,
    point: FloatArray,
    table: FloatArray,
    basis: IntArray,
    tolerance: float,
    sweep_limit: int,
) -> tuple[int, int, int]:
    """Sweep, look, try to finish on the active set; (status, sweeps, 1 if finished there).

    G, free, friction, tangent_of, forces, states as of :func:`sweep_delassus`, forces the point to begin from; M (n, n)
    and q (n,) the three-unknown form, on which points are judged. Out: z (n,) the best point, basis[:n] if solved.
    Work: point (n,), table and basis of ``lemke_workspace(n)``.
    """
    m, n = len(free), len(q)
    load = 0.0
    for i in range(m):
        load = max(load, abs(free[i]))
    for i in range(n):
        z[i] = 0.0
        basis[i] = 0
    least = judge(M, q, z, n, table[n])
    target, look, sweeps = 0.1 * tolerance * load, FIRST_LOOK, 0
    while least > tolerance and sweeps < sweep_limit and not is_called(basis):
        made, change = sweep_delassus(
            G, free, friction, tangent_of, forces, states, min(look, sweep_limit) - sweeps, target
        )
        sweeps += made
        look *= 2
        if not change < RUNAWAY * load:
            return NUMERICAL_FAILURE, sweeps, 0
        _take_point(G, free, friction, tangent_of, forces, point)
        take_basis(states, tangent_of, m, point, basis)
        for finished in range(2):
            if finished == 1:
                solves, residual = block_pivots(M, q, n, point, table, basis, EXCHANGES)
            else:
                solves, residual = 1, judge(M, q, point, n, table[n])
            if solves > 0 and residual < least:
                least = residual
                for i in range(n):
                    z[i] = point[i]
                if least <= tolerance:
                    return SOLVED, sweeps, finished
        if change <= target:
            target *= 0.1
            if target < LAST_DIGIT * load:
                return NUMERICAL_FAILURE, sweeps, 0
    return SOLVED if least <= tolerance else ITERATION_LIMIT, sweeps, 0
