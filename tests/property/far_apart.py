"""Contact problems of masses far apart and LCPs of entries far apart, and a judge of answers in rational numbers.

The judge solves the equations of an active set exactly and exchanges what has the wrong sign, so that it knows a
solution of the numbers as they are, where its search ends with one; and it measures any point row by row without
rounding. It shares no code with the library but the classes of problems.
"""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np

from lcpflex.solvers import ContactProblem, Lcp

MOST_SETS = 60  # active sets that the judge tries
ZERO = Fraction(0)


def rows_of_bodies(rng, contacts, mu, ratio):
    """Rows of contacts of at least two bodies whose largest and smallest masses are 10^ratio apart, and root masses."""
    bodies = max(2, round(contacts * rng.uniform(0.3, 1.5)))
    share = rng.uniform(0.0, 1.0, bodies)
    share[rng.choice(bodies, 2, replace=False)] = 0.0, 1.0
    masses = 10.0 ** (ratio * (share - 0.5))
    inertia = masses * rng.uniform(0.1, 1.0, bodies)
    root = np.sqrt(np.repeat(masses, 3))
    root[2::3] = np.sqrt(inertia)
    tangent = np.flatnonzero(mu)
    J = np.zeros((contacts + len(tangent), 3 * bodies))
    for k in range(contacts):
        angle = rng.uniform(0, 2 * np.pi) if rng.random() < 0.7 else np.pi / 2
        n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        pair = rng.choice(bodies, size=2, replace=False)
        row_t = contacts + int(np.searchsorted(tangent, k))
        for sign, body in zip((1.0, -1.0), pair[: rng.integers(1, 3)], strict=False):
            arm = rng.uniform(-1, 1, 2)
            for row, e in ((k, n), (row_t, t)) if mu[k] else ((k, n),):
                J[row, 3 * body : 3 * body + 3] = sign * np.array([e[0], e[1], arm[0] * e[1] - arm[1] * e[0]])
    return J, root, masses


def contact_case(seed, ratio, largest=8):
    """(problem, whether a solution of it is known but for rounding): velocities of one size, or of a known motion.

    Known impulses are of the size of each contact's own mass, or of any of the masses.
    """
    rng = np.random.default_rng([77, seed])
    contacts = int(rng.integers(2, largest + 1))
    mu = np.where(rng.random(contacts) < 0.15, 0.0, rng.uniform(0.05, rng.choice([0.3, 0.8, 1.5]), contacts))
    raw, root, masses = rows_of_bodies(rng, contacts, mu, ratio)
    J = raw / root
    G, tangent, kind = J @ J.T, np.flatnonzero(mu), int(rng.integers(0, 3))
    if kind == 2:
        return ContactProblem(G, raw @ rng.standard_normal(raw.shape[1]), mu), False
    own = np.diag(G)[:contacts].copy()
    own[tangent] = np.maximum(own[tangent], np.diag(G)[contacts:])
    size = 1.0 / own
    if kind == 1:
        size = 10.0 ** rng.uniform(np.log10(masses.min()), np.log10(masses.max()), contacts)
    state = rng.choice(4, size=contacts, p=[0.35, 0.35, 0.15, 0.15])  # open, sticking, sliding forth, back
    verge = rng.random(contacts) < 0.1
    p = np.where((state == 0) | verge, 0.0, rng.exponential(1.0, contacts)) * size
    v = np.where((state == 0) & ~verge, rng.exponential(1.0, contacts), 0.0)
    share = np.select([state == 2, state == 3], [-1.0, 1.0], rng.uniform(-1, 1, contacts))
    slip = np.select([state == 1, state == 2, state == 3], [0.0, 1.0, -1.0], rng.standard_normal(contacts))
    slip = slip * np.where(state > 1, rng.exponential(1.0, contacts), 1.0)
    force = np.concatenate([p, (share * mu * p)[tangent]])
    return ContactProblem(G, np.concatenate([v, slip[tangent]]) - G @ force, mu), True


def lcp_case(seed):
    """(problem, whether a solution is known but for rounding): entries of any sign over 2^-40 to 2^40.

    By turns full, sparse, of positive diagonal, nearly nonnegative, and made around a solution.
    """
    rng = np.random.default_rng([4040, seed])
    n, kind = int(rng.integers(2, 6)), seed % 5

    def entries(*shape):
        sign, digits = rng.choice([-1.0, 1.0], shape), np.round(rng.uniform(1, 2, shape), 3)
        return sign * digits * 2.0 ** rng.uniform(-40, 40, shape).round()

    M = entries(n, n)
    if kind == 4:
        z = abs(entries(n)) * (rng.random(n) < 0.5)
        return Lcp(M, abs(entries(n)) * (z == 0.0) - M @ z), True
    q = entries(n)
    if kind == 1:
        M *= rng.random((n, n)) < 0.6
    elif kind == 2:
        np.fill_diagonal(M, abs(np.diag(M)))
    elif kind == 3:
        M, q = abs(M) * np.where(rng.random((n, n)) < 0.3, -1.0, 1.0), -abs(q)
    return Lcp(M, q), False


def exact_form(problem):
    """M and q in fractions; of contacts in three unknowns each, without the rounding of G_T mu."""
    if isinstance(problem, Lcp):
        return [fractions(row) for row in problem.M], fractions(problem.q)
    G, mu, q = [fractions(row) for row in problem.delassus], fractions(problem.friction), fractions(problem.free)
    tangent, n, m = np.flatnonzero(problem.friction).tolist(), len(mu), len(q)
    size = m + len(tangent)
    M = [[ZERO] * size for _ in range(size)]
    for i in range(m):
        M[i][:m] = G[i]
        for j, k in enumerate(tangent):
            M[i][k] = M[i][k] - mu[k] * G[i][n + j]
        if i >= n:
            M[i][m + i - n] = Fraction(1)
    for j, k in enumerate(tangent):
        M[m + j][k], M[m + j][n + j] = 2 * mu[k], Fraction(-1)
    return M, q + [ZERO] * len(tangent)


def fractions(values):
    return [Fraction(float(x)) for x in values]


def slack(M, q, z):
    return [sum((a * b for a, b in zip(row, z, strict=True) if a and b), c) for row, c in zip(M, q, strict=True)]


def on_set(M, q, basic):
    """(z, w) with w = 0 on the set and z = 0 off it, None where that is singular."""
    chosen = [i for i, on in enumerate(basic) if on]
    rows = [[M[i][j] for j in chosen] + [-q[i]] for i in chosen]
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i, row in enumerate(rows):
            if i != k and row[k]:
                rows[i] = [x - row[k] * y for x, y in zip(row, rows[k], strict=True)]
    z = [ZERO] * len(q)
    for i, row in zip(chosen, rows, strict=True):
        z[i] = row[-1]
    return z, slack(M, q, z)


def solution_near(M, q, basic):
    """A solution that exchanges from this active set lead to, None where they lead to none."""
    basic, fewest, patience = list(basic), len(q) + 1, 3
    for _ in range(MOST_SETS):
        found = on_set(M, q, basic)
        if found is None:
            return None
        z, w = found
        wrong = [i for i, on in enumerate(basic) if (z[i] if on else w[i]) < 0]
        if not wrong:
            return found
        fewest, patience = (len(wrong), 3) if len(wrong) < fewest else (fewest, patience - 1)
        for i in wrong if patience >= 0 else wrong[-1:]:
            basic[i] = not basic[i]
    return None


def all_solutions(M, q):
    """Every solution on a regular active set, and whether some sets are singular."""
    found, singular = [], False
    for basic in itertools.product((False, True), repeat=len(q)):
        on = on_set(M, q, basic)
        singular = singular or on is None
        if on is not None and min(*on[0], *on[1]) >= 0:
            found.append(on[0])
    return found, singular


def off_by(problem, z, w):
    """How far contact velocities are from those of the exact solution (z, w), relative to each contact's own load.

    Which counts as no less than a thousandth of its terms, as far as all else moves as fast, and than
    1e-12 of the fastest velocity. None without a solution.
    """
    M, q = exact_form(problem)
    mu, tangent = problem.friction, np.flatnonzero(problem.friction).tolist()
    n, m = len(mu), len(problem.free)
    point = fractions(z)
    basic = np.asarray(z) > 0.0
    near = solution_near(M, q, basic)
    if near is None:
        units = problem.unknown_units.d
        near = solution_near(M, q, np.asarray(z) / units > np.asarray(w) * units)
    if near is None:
        return None
    own = slack(M, q, point)
    terms = [sum((abs(a * b) for a, b in zip(r, point, strict=True)), abs(c)) for r, c in zip(M, q, strict=True)]

    def speed(z, w, i):
        return w[i] - z[m + i - n] if i >= n else w[i]

    fastest, worst = max(abs(x) for x in q[:m]), 0.0
    for k in range(n):
        rows = [k] + [n + j for j, contact in enumerate(tangent) if contact == k]
        load = max(abs(q[i]) for i in rows)
        size = max(terms[i] for i in rows)
        load = max(load, min(size, fastest) / 1000, fastest / 10**12)
        off = max(abs(speed(point, own, i) - speed(*near, i)) for i in rows)
        worst = max(worst, float(off / load) if load else float(off != 0))
    return worst


def left_of_rows(M, q, z):
    """max_i |min(m_i z_i, w_i)| / (|q_i| + sum |M_ij z_j|) without rounding, m_i the largest |M_ij|, 1 if that is 0."""
    point, worst = fractions(z), ZERO
    for i, row in enumerate(M):
        parts = [a * x for a, x in zip(row, point, strict=True)]
        terms = sum(map(abs, parts), abs(q[i]))
        miss = abs(min((max(map(abs, row)) or 1) * point[i], sum(parts, q[i])))
        worst = max(worst, miss / terms if miss else ZERO)
    return float(worst)
