"""Contact problems in space with cones and known slip side by side, solved: see :mod:`.mixed_problem`.

Sweeps with the exact law of one contact, Newton's method on F (Alart & Curnier 1991) with a Jacobian that is kept
regular and a search that need not descend, and a proximal point where that stalls: see spatial contact problems.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.cones.mixed_problem import LOOK_BACK, MixedProblem, fill_units, judge_mixed
from lcpflex.solvers.contact.laws.disc import NONE, solve_cone

__all__ = ["polish_mixed", "solve_mixed"]

EXACT = 1e-14  # of the terms: nothing is gained below
SWEEPS, MORE_SWEEPS = 20, 2000
STEPS = 40  # of Newton
HALVINGS = 12
REGULAR = 1e-10  # on the diagonal of W in the Jacobian alone, of its largest
PROXIMAL = 60  # points
FIRST_WEIGHT, FALL, LEAST_WEIGHT = 0.1, 0.2, 1e-9
INNER = 8  # of a contact that carries something at least


@kernel
def without(p: MixedProblem, i: int, c: int) -> float:
    """u_i without the forces of contact c itself."""
    t, total = p.at[c], p.q[i]
    for j in range(p.m):
        total += p.W[i, j] * p.r[j]
    total -= p.W[i, c] * p.r[c]
    if t >= 0:
        total -= p.W[i, t] * p.r[t] + p.W[i, t + 1] * p.r[t + 1]
    return float(total)


@kernel
def relax_floored(p: MixedProblem, c: int, q_n: float, q_1: float, q_2: float) -> None:
    """Some projected steps of a contact that carries at least ``floor``, with the velocities of the others."""
    W, r, t = p.W, p.r, p.at[c]
    mean = W[t, t] + W[t + 1, t + 1]
    for _ in range(INNER):
        u_n = q_n + W[c, c] * r[c] + W[c, t] * r[t] + W[c, t + 1] * r[t + 1]
        if W[c, c] > 0.0:
            r[c] = max(p.floor[c], r[c] - u_n / W[c, c])
        if not mean > 0.0:
            return
        u_1 = q_1 + W[t, c] * r[c] + W[t, t] * r[t] + W[t, t + 1] * r[t + 1]
        u_2 = q_2 + W[t + 1, c] * r[c] + W[t + 1, t] * r[t] + W[t + 1, t + 1] * r[t + 1]
        y_1, y_2 = r[t] - u_1 / mean, r[t + 1] - u_2 / mean
        length, radius = math.hypot(y_1, y_2), p.friction[c] * r[c]
        shrink = 1.0 if length <= radius else radius / length
        r[t], r[t + 1] = shrink * y_1, shrink * y_2


@kernel
def sweep(p: MixedProblem) -> None:
    """Each contact in turn, the others being as they are."""
    W, r = p.W, p.r
    for c in range(p.n):
        t = p.at[c]
        q_n = without(p, c, c)
        if t < 0:
            if W[c, c] > 0.0:
                r[c] = max(p.floor[c], -q_n / W[c, c])
            elif q_n >= 0.0:
                r[c] = p.floor[c]
            continue
        q_1, q_2 = without(p, t, c), without(p, t + 1, c)
        if p.floor[c] > 0.0:
            relax_floored(p, c, q_n, q_1, q_2)
            continue
        r_n, r_1, r_2, slip = solve_cone(
            W[c, c], W[c, t], W[c, t + 1], W[t, t], W[t, t + 1], W[t + 1, t + 1],
            q_n, q_1, q_2, p.friction[c], p.slip[c],
        )  # fmt: skip
        if slip != NONE:
            r[c], r[t], r[t + 1] = r_n, r_1, r_2
            p.slip[c] = slip


@kernel
def velocities(p: MixedProblem, x: FloatArray) -> None:
    """p.u of forces x, both in units of the contacts, with the proximal term."""
    for i in range(p.m):
        total = p.unit[i] * p.q[i] + p.weight * (x[i] - p.centre[i])
        for j in range(p.m):
            total += p.unit[i] * p.W[i, j] * p.unit[j] * x[j]
        p.u[i] = total


@kernel
def misses(p: MixedProblem, x: FloatArray) -> float:
    """p.miss = F(x), and its length."""
    velocities(p, x)
    square = 0.0
    for c in range(p.n):
        t = p.at[c]
        press = max(p.floor[c] / p.unit[c], x[c] - p.u[c])
        p.miss[c] = x[c] - press
        square += p.miss[c] ** 2
        if t >= 0:
            y_1, y_2 = x[t] - p.u[t], x[t + 1] - p.u[t + 1]
            length, radius = math.hypot(y_1, y_2), p.friction[c] * press
            if length <= radius:
                p.miss[t], p.miss[t + 1] = p.u[t], p.u[t + 1]
            else:
                p.miss[t] = x[t] - y_1 * (radius / length)
                p.miss[t + 1] = x[t + 1] - y_2 * (radius / length)
            square += p.miss[t] ** 2 + p.miss[t + 1] ** 2
    return math.sqrt(square)


@kernel
def response(p: MixedProblem, i: int, j: int) -> float:
    """Entry of W in units of the contacts, with the proximal term, kept regular."""
    value = float(p.unit[i] * p.W[i, j] * p.unit[j])
    return value + p.weight + REGULAR if i == j else value


@kernel
def fill_jacobian(p: MixedProblem, x: FloatArray) -> None:
    """A generalised Jacobian of F at x, after ``misses`` there."""
    m, J = p.m, p.jacobian
    for c in range(p.n):
        t, floor = p.at[c], p.floor[c] / p.unit[c]
        y = x[c] - p.u[c]
        pressed = y > floor
        for j in range(m):
            J[c, j] = response(p, c, j) if pressed else (1.0 if j == c else 0.0)
        if t < 0:
            continue
        y_1, y_2 = x[t] - p.u[t], x[t + 1] - p.u[t + 1]
        length, radius = math.hypot(y_1, y_2), p.friction[c] * max(floor, y)
        if length <= radius:
            for j in range(m):
                J[t, j] = response(p, t, j)
                J[t + 1, j] = response(p, t + 1, j)
            continue
        e_1, e_2, k = y_1 / length, y_2 / length, radius / length
        for j in range(m):
            d_1 = (1.0 if j == t else 0.0) - response(p, t, j)
            d_2 = (1.0 if j == t + 1 else 0.0) - response(p, t + 1, j)
            along = e_1 * d_1 + e_2 * d_2
            grip = p.friction[c] * ((1.0 if j == c else 0.0) - response(p, c, j)) if pressed else 0.0
            J[t, j] = (1.0 if j == t else 0.0) - k * (d_1 - e_1 * along) - e_1 * grip
            J[t + 1, j] = (1.0 if j == t + 1 else 0.0) - k * (d_2 - e_2 * along) - e_2 * grip


@kernel
def solve_linear(A: FloatArray, m: int, b: FloatArray) -> bool:
    """b <- A^-1 b by elimination with pivots from each column; False where A is singular. A is lost."""
    for k in range(m):
        pivot = k
        for i in range(k + 1, m):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if not abs(A[pivot, k]) > 0.0:
            return False
        if pivot != k:
            b[k], b[pivot] = b[pivot], b[k]
            for j in range(k, m):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        for i in range(k + 1, m):
            factor = A[i, k] / A[k, k]
            if factor != 0.0:
                b[i] -= factor * b[k]
                for j in range(k + 1, m):
                    A[i, j] -= factor * A[k, j]
    for i in range(m - 1, -1, -1):
        for j in range(i + 1, m):
            b[i] -= A[i, j] * b[j]
        b[i] /= A[i, i]
    return True


@kernel
def newton(p: MixedProblem, exact: float) -> float:
    """Newton's method from p.x; the length of F that it comes to."""
    m = p.m
    size = misses(p, p.x)
    for i in range(LOOK_BACK):
        p.back[i] = size
    for turn in range(STEPS):
        if size <= exact:
            break
        fill_jacobian(p, p.x)
        for i in range(m):
            p.step[i] = p.miss[i]
        if not solve_linear(p.jacobian, m, p.step):
            break
        allowed = 0.0
        for i in range(LOOK_BACK):
            allowed = max(allowed, p.back[i])
        length, found = 1.0, size
        for _ in range(HALVINGS):
            for i in range(m):
                p.trial[i] = p.x[i] - length * p.step[i]
            found = misses(p, p.trial)
            if found <= (1.0 - 1e-4 * length) * allowed:
                break
            length *= 0.5
        if not found < np.inf:
            break
        still = found >= size and size <= 1e3 * exact
        for i in range(m):
            p.x[i] = p.trial[i]
        size = found
        p.back[turn % LOOK_BACK] = size
        p.iterations += 1
        if still:
            break
    return size


@kernel
def keep_better(p: MixedProblem, known: float) -> float:
    """Judge p.x; the better one of it and ``p.best`` stays there. Its residual."""
    for i in range(p.m):
        p.trial[i] = p.unit[i] * p.x[i]
    found = judge_mixed(p, p.trial)
    if found < known:
        for i in range(p.m):
            p.best[i] = p.trial[i]
        return found
    return known


@kernel
def begin_from(p: MixedProblem, r: FloatArray) -> None:
    """p.x = r in units of the contacts, and the centre of the proximal term."""
    for i in range(p.m):
        p.x[i] = r[i] / p.unit[i]
        p.centre[i] = p.x[i]


@kernel
def swept(p: MixedProblem, sweeps: int, known: float) -> float:
    """Sweeps from p.r; the better one of their end and ``p.best`` stays there. Its residual."""
    for turn in range(sweeps):
        sweep(p)
        p.iterations += 1
        if turn % 4 == 3 or turn == sweeps - 1 or turn == 0:
            found = judge_mixed(p, p.r)
            if found < known:
                known = found
                for i in range(p.m):
                    p.best[i] = p.r[i]
            if known <= EXACT:
                break
    return known


@kernel
def approach(p: MixedProblem, exact: float, known: float) -> float:
    """Proximal points from the best one, each found by Newton's method; the residual of the best."""
    begin_from(p, p.best)
    p.weight = FIRST_WEIGHT
    for _ in range(PROXIMAL):
        size = newton(p, exact)
        if size <= 1e6 * exact:
            p.weight = max(LEAST_WEIGHT, FALL * p.weight)
        elif p.weight < 1.0:
            p.weight *= 10.0
        else:
            break
        for i in range(p.m):
            p.centre[i] = p.x[i]
        known = keep_better(p, known)
        if known <= EXACT:
            break
    p.weight = 0.0
    return known


@kernel
def solve_mixed(p: MixedProblem, tolerance: float) -> float:
    """The forces p.r from nothing; their residual, as far below ``tolerance`` as it comes without much more."""
    fill_units(p)
    p.iterations = 0
    p.weight = 0.0
    load = 0.0
    for c in range(p.n):
        p.slip[c] = 0.0
    for i in range(p.m):
        p.r[i] = 0.0
        load = max(load, p.unit[i] * abs(p.q[i]))
    for c in range(p.n):
        p.r[c] = p.floor[c]
    for i in range(p.m):
        p.best[i] = p.r[i]
    exact = EXACT * load
    known = swept(p, SWEEPS, judge_mixed(p, p.r))
    if known > EXACT:
        begin_from(p, p.best)
        newton(p, exact)
        known = keep_better(p, known)
    if known > tolerance:
        known = approach(p, exact, known)
    if known > tolerance:
        for i in range(p.m):
            p.r[i] = p.best[i]
        known = swept(p, MORE_SWEEPS, known)
        begin_from(p, p.best)
        newton(p, exact)
        known = keep_better(p, known)
    for i in range(p.m):
        p.r[i] = p.best[i]
    return judge_mixed(p, p.r)


@kernel
def polish_mixed(p: MixedProblem) -> float:
    """Newton's method from the forces p.r; their residual."""
    load = 0.0
    for i in range(p.m):
        load = max(load, p.unit[i] * abs(p.q[i]))
    begin_from(p, p.r)
    newton(p, EXACT * load)
    for i in range(p.m):
        p.r[i] = p.unit[i] * p.x[i]
    return judge_mixed(p, p.r)
