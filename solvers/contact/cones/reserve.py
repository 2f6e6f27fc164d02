"""Of all forces of contacts that share a load in many ways, those that are farthest inside Coulomb's law.

Forces r of contacts at rest are changed by null vectors of W only, r = r0 + B y, so that nothing moves. Wanted is the
least t for which all of

    |r_T| <= mu (r_N + t L),    L a given force,    sum r_N < S,

hold: t < 0 tells that the contacts stick with a reserve -t, t = 0 that they are at the limit. A path of centres,
min t / eps - sum log(mu^2 (r_N + t L)^2 - |r_T|^2) - log(S - sum r_N), eps -> 0, is followed by damped Newton steps,
which a self-concordant function allows without a search (Boyd & Vandenberghe, Convex Optimization, 2004, 9.6 and
11.6.2). The path ends where t is known but for half of it.

Walls could clamp what is between them as hard as one likes, and so hold it against any load. No more than the loads
make them press is allowed: S is what was found, or what the shortest r of all is, in units of the contacts, as welded
joints of equal compliance would have it.

Contacts that slide in a solution may have another one in which all are held, W r = -q. Its forces are any that hold,
changed by null vectors as well.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem
from lcpflex.solvers.dense_factor import factorise_rows, solve_rows

__all__ = ["LIMIT", "UNIQUE", "held_forces", "most_reserve"]

UNIQUE = -2.0  # told instead of a reserve: forces can not be changed
LIMIT = 1e-9  # of a reserve: contacts with less begin to slide
MORE = 1e-6  # of S, beyond it: the shortest forces are strictly inside
MISSED = 1e-6  # of what is to be held: a row that nearly depends on others leaves the root of its pivot there
DEPENDENT = 1e-11  # of the first pivot: a smaller one is rounding
FALL, LEAST = 0.1, 1e-10  # of eps
STEPS = 40  # of Newton for each eps
CENTRED = 0.1  # Newton decrement
KNOWN = 4.0  # eps times that a contact: t is as near as that to its least
REGULAR = 1e-3  # forces that clamp each other do not grow without bound


@kernel
def members(p: MixedProblem) -> int:
    """The unknowns of contacts at rest to ``p.member``; how many."""
    count = 0
    for c in range(p.n):
        if p.rests[c] == 1:
            p.member[count] = c
            count += 1
            if p.at[c] >= 0:
                p.member[count] = p.at[c]
                p.member[count + 1] = p.at[c] + 1
                count += 2
    return count


@kernel
def right_sides(p: MixedProblem, m: int) -> float:
    """What the contacts at rest are to undo, to ``p.step`` in their units; its size."""
    size = 0.0
    for i in range(m):
        r = p.member[i]
        total = p.q[r]
        for s in range(p.m):
            total += p.W[r, s] * p.r[s]
        for j in range(m):
            total -= p.W[r, p.member[j]] * p.r[p.member[j]]
        p.step[i] = -p.unit[r] * total
        size = max(size, abs(p.step[i]))
    return size


@kernel
def swap(p: MixedProblem, k: int, i: int, j: int, m: int) -> None:
    """Row i and column j of the elimination to place k."""
    a = p.jacobian
    if i != k:
        p.step[k], p.step[i] = p.step[i], p.step[k]
        for c in range(m):
            a[k, c], a[i, c] = a[i, c], a[k, c]
    if j != k:
        p.member[k], p.member[j] = p.member[j], p.member[k]
        for r in range(m):
            a[r, k], a[r, j] = a[r, j], a[r, k]


@kernel
def null_vectors(p: MixedProblem, m: int) -> int:
    """Columns B to ``p.basis``, rows by unknowns, their largest entry 1; how many. By Gauss and Jordan.

    The right-hand sides ``p.step`` are eliminated with the rows.
    """
    a, rank, first = p.jacobian, m, 0.0
    for i in range(m):
        for j in range(m):
            a[i, j] = p.unit[p.member[i]] * p.W[p.member[i], p.member[j]] * p.unit[p.member[j]]
    for k in range(m):
        r, s = k, k
        for i in range(k, m):
            for j in range(k, m):
                if abs(a[i, j]) > abs(a[r, s]):
                    r, s = i, j
        first = max(first, abs(a[r, s]))
        if not abs(a[r, s]) > DEPENDENT * first:
            rank = k
            break
        swap(p, k, r, s, m)
        p.step[k] /= a[k, k]
        for j in range(m - 1, k - 1, -1):
            a[k, j] /= a[k, k]
        for i in range(m):
            factor = a[i, k]
            if i != k and factor != 0.0:
                p.step[i] -= factor * p.step[k]
                for j in range(k, m):
                    a[i, j] -= factor * a[k, j]
    for f in range(m - rank):
        for r in range(p.m):
            p.basis[r, f] = 0.0
        p.basis[p.member[rank + f], f] = p.unit[p.member[rank + f]]
        size = p.unit[p.member[rank + f]]
        for k in range(rank):
            value = -p.unit[p.member[k]] * a[k, rank + f]
            p.basis[p.member[k], f] = value
            size = max(size, abs(value))
        for r in range(p.m):
            p.basis[r, f] /= size
    return m - rank


@kernel
def changed(p: MixedProblem, free: int, size: float) -> None:
    """``p.x``: all forces over L with the coefficients ``p.centre``."""
    for r in range(p.m):
        total = p.r[r] / size
        for f in range(free):
            total += p.basis[r, f] * p.centre[f]
        p.x[r] = total


@kernel
def pressed(p: MixedProblem, r: FloatArray) -> float:
    """All normal forces of the contacts at rest, whether they press or pull."""
    total = 0.0
    for c in range(p.n):
        if p.rests[c] == 1:
            total += abs(r[c])
    return total


@kernel
def solve_step(p: MixedProblem, m: int) -> bool:
    """``step`` := H^-1 step, H the leading m rows of ``jacobian``, which are lost; False where H is singular."""
    found = factorise_rows(p.jacobian, m, p.pivots)
    if found:
        solve_rows(p.jacobian, m, p.pivots, p.step, p.trial)
    return found


@kernel
def shorten(p: MixedProblem, free: int) -> None:
    """The forces p.r without what they have of ``free`` null vectors, in units of the contacts."""
    B, H = p.basis, p.jacobian
    for a in range(free):
        p.step[a] = 0.0
        for b in range(free):
            H[a, b] = 0.0
    for r in range(p.m):
        square = p.unit[r] * p.unit[r]
        for a in range(free):
            if B[r, a] != 0.0:
                p.step[a] += B[r, a] * p.r[r] / square
                for b in range(free):
                    H[a, b] += B[r, a] * B[r, b] / square
    if solve_step(p, free):
        for r in range(p.m):
            for a in range(free):
                p.r[r] -= B[r, a] * p.step[a]


@kernel
def room(p: MixedProblem) -> float:
    """What is left of S at ``p.x``, over L."""
    left = p.most
    for c in range(p.n):
        if p.rests[c] == 1:
            left -= p.x[c]
    return left


@kernel
def inside(p: MixedProblem, c: int, t: float) -> float:
    """(r_N + t L)^2 - |r_T / mu|^2 over L^2, or r_N / L + t without friction; 0 outside."""
    press = float(p.x[c] + t)
    if p.at[c] < 0:
        return max(0.0, press)
    pull = math.hypot(p.x[p.at[c]], p.x[p.at[c] + 1]) / p.friction[c]
    return (press - pull) * (press + pull) if press > pull else 0.0


@kernel
def all_inside(p: MixedProblem, t: float) -> bool:
    """Whether all laws hold strictly."""
    holds = 1.0 + t > 0.0 and room(p) > 0.0
    for c in range(p.n):
        holds = holds and (p.rests[c] == 0 or inside(p, c, t) > 0.0)
    return holds


@kernel
def changing(p: MixedProblem, c: int, free: int) -> int:
    """The coefficients that change what contact c is inside by, to ``p.member``, t as the last one; how many.

    Few of many: forces that nothing determines are mostly those of one pair of bodies.
    """
    j, B, count = p.at[c], p.basis, 0
    for a in range(free):
        if B[c, a] != 0.0 or (j >= 0 and (B[j, a] != 0.0 or B[j + 1, a] != 0.0)):
            p.member[count] = a
            count += 1
    p.member[count] = free
    return count + 1


@kernel
def add_contact(p: MixedProblem, c: int, t: float, free: int) -> None:
    """Gradient, to ``p.step``, and second derivatives, to ``p.jacobian``, of -log(inside) of contact c."""
    j, v, B, H = p.at[c], inside(p, c, t), p.basis, p.jacobian
    press = p.x[c] + t
    count = changing(p, c, free)
    for number in range(count):
        a = p.member[number]
        n_a = B[c, a] if a < free else 1.0
        g_a, first, second = n_a, 0.0, 0.0
        if j >= 0:
            first = B[j, a] / p.friction[c] if a < free else 0.0
            second = B[j + 1, a] / p.friction[c] if a < free else 0.0
            g_a = 2.0 * (press * n_a - (p.x[j] * first + p.x[j + 1] * second) / p.friction[c])
        p.trial[a] = g_a / v
        p.step[a] -= g_a / v
        for other in range(number + 1):
            b = p.member[other]
            h = p.trial[a] * p.trial[b]
            if j >= 0:
                n_b = B[c, b] if b < free else 1.0
                if b < free:
                    h += 2.0 * (first * B[j, b] + second * B[j + 1, b]) / (p.friction[c] * v)
                h -= 2.0 * n_a * n_b / v
            H[a, b] += h


@kernel
def add_total(p: MixedProblem, free: int) -> None:
    """The same of -log(room)."""
    v = room(p)
    for a in range(free):
        p.trial[a] = 0.0
        for c in range(p.n):
            if p.rests[c] == 1:
                p.trial[a] += p.basis[c, a] / v
        p.step[a] += p.trial[a]
        for b in range(a + 1):
            p.jacobian[a, b] += p.trial[a] * p.trial[b]


@kernel
def derivatives(p: MixedProblem, t: float, eps: float, free: int) -> None:
    """Gradient to ``p.step`` and ``p.best``, second derivatives to ``p.jacobian``."""
    H = p.jacobian
    for a in range(free + 1):
        for b in range(free + 1):
            H[a, b] = 0.0
        p.step[a] = REGULAR * p.centre[a] if a < free else 1.0 / eps - 1.0 / (1.0 + t)
        H[a, a] = REGULAR if a < free else 1.0 / (1.0 + t) ** 2
    for c in range(p.n):
        if p.rests[c] == 1:
            add_contact(p, c, t, free)
    add_total(p, free)
    for a in range(free + 1):
        p.best[a] = p.step[a]
        for b in range(a):
            H[b, a] = H[a, b]


@kernel
def centre(p: MixedProblem, t: float, eps: float, free: int, size: float) -> float:
    """Newton's method for one eps from the coefficients ``p.centre`` and t; returns t."""
    for _ in range(STEPS):
        derivatives(p, t, eps, free)
        if not solve_step(p, free + 1):
            break
        square = 0.0
        for a in range(free + 1):
            square += p.best[a] * p.step[a]
        if not 0.0 <= square < math.inf:
            break
        decrement = math.sqrt(square)
        length = 1.0 if decrement < 0.25 else 1.0 / (1.0 + decrement)
        for a in range(free):
            p.centre[a] -= length * p.step[a]
        changed(p, free, size)
        if not all_inside(p, t - length * p.step[free]):  # by rounding only
            for a in range(free):
                p.centre[a] += length * p.step[a]
            changed(p, free, size)
            break
        t -= length * p.step[free]
        if decrement < CENTRED:
            break
    return t


@kernel
def find_reserve(p: MixedProblem, free: int, size: float, exact: bool) -> float:
    """The forces p.r with as much as is best of ``free`` null vectors to ``p.x``; their reserve over ``size``.

    p.r become the shortest ones, p.most is S. Where the law is broken at best, the forces are nearly those that break
    it least if ``exact``; else they are as near as where it holds.
    """
    resting, t = 0, 0.0
    shorten(p, free)
    p.most = (1.0 + MORE) * max(p.most, pressed(p, p.r)) / size
    for f in range(free):
        p.centre[f] = 0.0
    changed(p, free, size)
    for c in range(p.n):
        if p.rests[c] == 1:
            resting += 1
            pull = 0.0 if p.at[c] < 0 else math.hypot(p.x[p.at[c]], p.x[p.at[c] + 1]) / p.friction[c]
            t = max(t, pull - p.x[c])
    t += 1.0
    eps = 1.0
    while eps >= LEAST:
        t = centre(p, t, eps, free, size)
        if (-t if exact else abs(t)) > KNOWN * resting * eps:
            break
        eps *= FALL
    for r in range(p.m):
        p.x[r] *= size
    return -t


@kernel
def most_reserve(p: MixedProblem, size: float) -> float:
    """The forces of those contacts that ``p.rests`` to ``p.x``, the others as in p.r; their reserve over L = ``size``.

    At most 1, below 0 where the law is broken at best; UNIQUE where forces can not be changed. ``p.r``, ``p.unit`` are
    those of a solved problem; W is symmetric among the contacts at rest.
    """
    count = members(p)
    p.most = pressed(p, p.r)
    free = null_vectors(p, count) if count > 0 and size > 0.0 else 0
    return find_reserve(p, free, size, True) if free > 0 else UNIQUE


@kernel
def held_forces(p: MixedProblem, size: float) -> float:
    """As :func:`most_reserve`, of forces that hold the contacts that ``p.rests``, whatever p.r is; UNIQUE: none do.

    Also where one set of forces alone does: p.r stays as it is in both cases.
    """
    count = members(p)
    if count == 0 or not size > 0.0:
        return UNIQUE
    p.most = pressed(p, p.r)
    most = right_sides(p, count)
    free = null_vectors(p, count)
    for k in range(count - free, count):
        if not abs(p.step[k]) <= MISSED * most:
            return UNIQUE
    if free == 0:
        return UNIQUE
    for k in range(count):
        r = p.member[k]
        p.r[r] = p.unit[r] * p.step[k] if k < count - free else 0.0
    return find_reserve(p, free, size, False)
