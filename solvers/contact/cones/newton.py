"""Newton's method on Alart and Curnier's function, and the proximal point iteration that rescues it.

For contacts in units of their own (:meth:`SpatialContactProblem.balanced`), in which the diagonal of W_kk is 1 at most.
Three things make the iteration robust: those units; a Jacobian that is made with W + delta I, the function itself with
W, so that an operator of half its rank (many contacts of few bodies) needs no least squares; and a line search that
may lose against the last value if it wins against one of the last four. Where it stalls,

    W r + q + alpha (r - r_k)   instead of   W r + q,   r_k the last point,

is solved: the smaller alpha, the nearer to the problem itself, and the harder. Alpha falls while that succeeds, and is
asked to fall more and more rarely where it does not. Points then drift along a line, by a thousandth of its length or
less each: r_k is put ahead on it, twice as far each time, until that no longer succeeds or the residual grows.
Sources: Alart & Curnier 1991; Acary, Bremond & Huber 2018 (comparison of solvers); Rockafellar 1976 (proximal points).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.attention import is_called
from lcpflex.solvers.contact.cones.alart_curnier import contact_miss, lengths, mixed_rows
from lcpflex.solvers.contact.cones.certificate import natural_miss
from lcpflex.solvers.contact.cones.linear import solve_general

__all__ = ["ConeWork", "cone_work", "direction", "distance", "expired", "look", "measure", "newton", "proximal"]

SHIFT = 1e-8  # of the Jacobian's W, whose largest diagonal entries are 1; by less, null vectors are mostly rounding
STRONGER = 100.0  # growth of that shift where the step is absurd
STRONGEST = 1.0
ABSURD = 1e6  # length of a step, relative to the forces
HALVINGS = 12
DESCENT = 1e-4  # share of the step that the function must fall by
MEMORY = 4  # values one of which must be beaten
FLOOR = 100.0  # goals: so near, a step that does not halve the function has met rounding
FIRST_PULL, FALL, WEAKEST, STRONGEST_PULL = 0.1, 5.0, 1e-9, 10.0  # alpha: at first, how it changes, its bounds
PATIENT = 16  # points at most with one alpha before a smaller one is tried again
WORSE = 1.2  # growth of the residual at which a point was put too far ahead
TRIED = 40  # Newton steps for one proximal point
ENOUGH = 1e-3  # residual of a proximal point relative to that of the problem
ROUNDING = 1e-13  # what is left of the function of a proximal point at best
POLISHING = 5  # Newton steps for the problem itself from the last proximal point


class ConeWork(NamedTuple):
    """Space for n contacts, m = 3 n rows: arrays may be larger."""

    rho: FloatArray  # (n, 2)
    velocity: FloatArray  # (m,) W r + q + alpha (r - r_k)
    miss: FloatArray  # (m,) F
    step: FloatArray  # (m,)
    point: FloatArray  # (m,) where Newton's method is
    trial: FloatArray  # (m,)
    centre: FloatArray  # (m,) r_k
    base: FloatArray  # (m,) the last point, behind r_k
    best: FloatArray  # (m,)
    table: FloatArray  # (m, m) the Jacobian, if that is dense
    small: FloatArray  # (22,) two blocks and the last values
    pivots: IntArray  # (m + 1,), and whether a signal has come: lcpflex.solvers.attention


def cone_work(n: int, dense: bool = True) -> ConeWork:
    """Space for problems of n contacts; without that of a dense Jacobian if it is not to be ``dense``."""
    m = 3 * n
    u, miss, step, point, trial, centre, base, best = np.zeros((8, m))
    side = m if dense else 0
    table, small, pivots = np.zeros((side, side)), np.zeros(18 + MEMORY), np.zeros(m + 1, dtype=np.int64)
    return ConeWork(np.ones((n, 2)), u, miss, step, point, trial, centre, base, best, table, small, pivots)


@kernel
def expired() -> bool:
    """Whether the time is up: never where there is no clock."""
    return False


@kernel
def measure(W: FloatArray, n: int, alpha: float, work: ConeWork) -> None:
    """work.rho of all contacts, with W + alpha I."""
    for k in range(n):
        i = 3 * k
        work.rho[k, 0], work.rho[k, 1] = lengths(
            W[i, i] + alpha, W[i + 1, i + 1] + alpha, W[i + 1, i + 2], W[i + 2, i + 1], W[i + 2, i + 2] + alpha
        )


@kernel
def look(
    W: FloatArray, free: FloatArray, friction: FloatArray, n: int, alpha: float, forces: FloatArray, work: ConeWork
) -> float:
    """work.velocity and work.miss of forces (m,) with W + alpha I and free - alpha work.centre; |F|."""
    m = 3 * n
    for i in range(m):
        row, total = W[i], 0.0
        for j in range(m):
            total += row[j] * forces[j]
        work.velocity[i] = total + free[i] + alpha * (forces[i] - work.centre[i])
    return misses(friction, n, forces, work)


@kernel
def misses(friction: FloatArray, n: int, forces: FloatArray, work: ConeWork) -> float:
    """work.miss from work.velocity, and its length."""
    total, u, rho, F = 0.0, work.velocity, work.rho, work.miss
    for k in range(n):
        i = 3 * k
        F[i], F[i + 1], F[i + 2] = contact_miss(
            forces[i], forces[i + 1], forces[i + 2], u[i], u[i + 1], u[i + 2], friction[k], rho[k, 0], rho[k, 1]
        )
        total += F[i] * F[i] + F[i + 1] * F[i + 1] + F[i + 2] * F[i + 2]
    return math.sqrt(total)


@kernel
def distance(free: FloatArray, friction: FloatArray, n: int, forces: FloatArray, work: ConeWork) -> float:
    """The strict residual of the forces, whose velocities (alpha = 0) are in ``work``."""
    worst, load, u = 0.0, 0.0, work.velocity
    for k in range(n):
        i = 3 * k
        miss = natural_miss(
            forces[i], forces[i + 1], forces[i + 2], u[i], u[i + 1], u[i + 2], friction[k], 1.0
        )  # fmt: skip
        worst = max(worst, miss)
        load = max(load, max(abs(free[i]), max(abs(free[i + 1]), abs(free[i + 2]))))
    if worst == 0.0:
        return 0.0
    return worst / load if load > 0.0 else np.inf


@kernel
def direction(W: FloatArray, friction: FloatArray, n: int, shift: float, forces: FloatArray, work: ConeWork) -> float:
    """work.step = -(I - P (I - rho (W + shift I)))^-1 F; its largest entry, inf where the matrix is singular."""
    m, u, rho = 3 * n, work.velocity, work.rho
    keep, take, table = work.small[:9], work.small[9:18], work.table
    for k in range(n):
        i = 3 * k
        mixed_rows(
            forces[i], forces[i + 1], forces[i + 2], u[i], u[i + 1], u[i + 2],
            friction[k], rho[k, 0], rho[k, 1], keep, take,
        )  # fmt: skip
        for a in range(3):
            t_n, t_1, t_2 = take[3 * a], take[3 * a + 1], take[3 * a + 2]
            row = table[i + a]
            for j in range(m):
                row[j] = 0.0
            if t_n != 0.0 or t_1 != 0.0 or t_2 != 0.0:
                first, second, third = W[i], W[i + 1], W[i + 2]
                for j in range(m):
                    row[j] = t_n * first[j] + t_1 * second[j] + t_2 * third[j]
                row[i] += t_n * shift
                row[i + 1] += t_1 * shift
                row[i + 2] += t_2 * shift
            for b in range(3):
                row[i + b] += keep[3 * a + b]
            work.step[i + a] = -work.miss[i + a]
    return solve_general(table, work.step, m, work.pivots)


@kernel
def _moved(point: FloatArray, share: float, step: FloatArray, m: int, out: FloatArray) -> float:
    """out = point + share step; the largest entry of the point."""
    largest = 0.0
    for i in range(m):
        largest = max(largest, abs(point[i]))
        out[i] = point[i] + share * step[i]
    return largest


@kernel
def _copied(source: FloatArray, m: int, target: FloatArray) -> None:
    for i in range(m):
        target[i] = source[i]


@kernel
def _largest(last: FloatArray) -> float:
    most = 0.0
    for i in range(MEMORY):
        most = max(most, last[i])
    return most


@kernel
def newton(
    W: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    n: int,
    alpha: float,
    forces: FloatArray,
    goal: float,
    limit: int,
    work: ConeWork,
) -> tuple[float, int]:
    """Newton's method for W + alpha I and free - alpha work.centre; (least |F| found, linear systems solved).

    W (cap, cap) dense, in units of the contacts; forces (cap,): from where, and out the best point. Ends at |F| <=
    goal, after ``limit`` systems, or where no step helps.
    """
    m, point, solved = 3 * n, work.point, 0
    last = work.small[18:]
    measure(W, n, alpha, work)
    _copied(forces, m, point)
    value = look(W, free, friction, n, alpha, point, work)
    least, count = value, 0
    for i in range(MEMORY):
        last[i] = value if i == 0 else 0.0
    while value > goal and solved < limit and not (expired() or is_called(work.pivots)):
        shift, length = SHIFT, np.inf
        size = _moved(point, 0.0, point, m, work.trial)
        while not length <= ABSURD * max(size, 1.0) and shift <= STRONGEST and solved < limit:
            length = direction(W, friction, n, alpha + shift, point, work)
            solved += 1
            shift *= STRONGER
        if not length <= ABSURD * max(size, 1.0):
            break
        share, beaten, most = 1.0, False, _largest(last)
        for _ in range(HALVINGS):
            _moved(point, share, work.step, m, work.trial)
            value = look(W, free, friction, n, alpha, work.trial, work)
            if value <= most * (1.0 - DESCENT * share):
                beaten = True
                break
            share *= 0.5
        if not beaten:
            break
        _copied(work.trial, m, point)
        count += 1
        last[count % MEMORY] = value
        stays = value > 0.5 * least and least <= FLOOR * goal
        if value < least:
            least = value
            _copied(point, m, forces)
        if stays:
            break
    return least, solved


@kernel
def _put_ahead(forces: FloatArray, share: float, m: int, work: ConeWork) -> None:
    """work.base = forces, work.centre = forces + share (forces - the last base)."""
    for i in range(m):
        work.centre[i] = forces[i] + share * (forces[i] - work.base[i])
        work.base[i] = forces[i]


@kernel
def proximal(
    W: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    n: int,
    forces: FloatArray,
    tolerance: float,
    limit: int,
    work: ConeWork,
) -> tuple[float, int]:
    """Proximal points until the strict residual is within the tolerance; (that, linear systems solved).

    Arrays as in :func:`newton`; forces: from where, and out the best point.
    """
    m, solved, alpha = 3 * n, 0, FIRST_PULL
    ahead, before, wait, patience = 0.0, np.inf, 0, 1
    look(W, free, friction, n, 0.0, forces, work)
    least = distance(free, friction, n, forces, work)
    _copied(forces, m, work.best)
    _copied(forces, m, work.base)
    _copied(forces, m, work.centre)
    while least > tolerance and solved < limit and not (expired() or is_called(work.pivots)):
        _copied(work.centre, m, forces)
        left, steps = newton(W, free, friction, n, alpha, forces, ROUNDING, min(TRIED, limit - solved), work)
        solved += max(steps, 1)
        look(W, free, friction, n, 0.0, forces, work)
        residual = distance(free, friction, n, forces, work)
        reached = left <= max(ROUNDING, ENOUGH * residual)
        if residual < least and (reached or residual <= tolerance):
            least = residual
            _copied(forces, m, work.best)
        if not reached or (ahead > 0.0 and residual > WORSE * before):
            if not reached:
                if ahead == 0.0:
                    alpha, patience = min(alpha * FALL, STRONGEST_PULL), min(2 * patience, PATIENT)
                wait = patience
            ahead, before = 0.0, np.inf
            _copied(work.base, m, work.centre)
            continue
        wait -= 1
        further = 2.0 * ahead + 1.0 if before < np.inf else 0.0
        if wait <= 0:
            alpha, further, wait, residual = max(alpha / FALL, WEAKEST), 0.0, 0, np.inf
        _put_ahead(forces, further / (1.0 + ahead), m, work)
        ahead, before = further, residual
    _copied(work.best, m, forces)
    if least <= tolerance:
        _, steps = newton(W, free, friction, n, 0.0, forces, ROUNDING, POLISHING, work)
        solved += steps
        look(W, free, friction, n, 0.0, forces, work)
        residual = distance(free, friction, n, forces, work)
        if not residual <= least:
            _copied(work.best, m, forces)
            residual = least
        least = residual
    return least, solved
