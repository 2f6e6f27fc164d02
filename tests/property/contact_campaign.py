"""Random contact problems in any units, and a judge of answers that shares no code with the library.

Bodies of three degrees of freedom with masses over eight decades; each contact touches one or two of them. A problem is
built around a known solution (open, sticking and sliding contacts, some of them on the verge), or has the free velocity
of a motion of the bodies. All is multiplied by 10^a in mass and 10^b in velocity.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from lcpflex.solvers import ContactProblem

GUARD = 1e-6
ROUNDING = 2.2e-16


@dataclass(frozen=True)
class Case:
    """G, free and mu in the units of the campaign, 10^mass and 10^speed; planted: whether a solution is known."""

    G: np.ndarray
    free: np.ndarray
    mu: np.ndarray
    planted: bool
    mass: float
    speed: float

    def problem(self, mass=0.0, speed=0.0):
        """The problem with all masses 10^mass and all velocities 10^speed times as large."""
        return ContactProblem(self.G * 10.0**-mass, self.free * 10.0**speed, self.mu)


def rows(rng, contacts, bodies, mu):
    """W^T M^(-1/2), normals first: directions and arms at random, the mass of each body in [1e-4, 1e4] or all 1."""
    masses = 10.0 ** (rng.uniform(-4, 4, bodies) if rng.random() < 0.6 else np.zeros(bodies))
    inertia = masses * rng.uniform(0.1, 1.0, bodies)
    inverse = 1.0 / np.sqrt(np.repeat(masses, 3))
    inverse[2::3] = 1.0 / np.sqrt(inertia)
    tangent = np.flatnonzero(mu)
    J = np.zeros((contacts + len(tangent), 3 * bodies))
    for k in range(contacts):
        angle = rng.uniform(0, 2 * np.pi) if rng.random() < 0.7 else np.pi / 2
        pair = rng.choice(bodies, size=min(2, bodies), replace=False)
        row_t = contacts + int(np.searchsorted(tangent, k))
        for sign, body in zip((1.0, -1.0), pair[: rng.integers(1, len(pair) + 1)], strict=False):
            arm = rng.uniform(-1, 1, 2)
            n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
            for row, e in ((k, n), (row_t, t)) if mu[k] else ((k, n),):
                J[row, 3 * body : 3 * body + 3] = sign * np.array([e[0], e[1], arm[0] * e[1] - arm[1] * e[0]])
    return J * inverse


def scales(G, n, tangent, number=np.float64):
    """1 / sqrt(max(G_NN, G_TT)) of every contact; one that cannot move at all takes the smallest of the others."""
    D = np.diag(G)[:n].copy()
    D[tangent] = np.maximum(D[tangent], np.diag(G)[n:])
    largest = D.max(initial=0.0) or 1.0
    return 1 / np.sqrt(np.where(D > 0.0, D, largest).astype(number))


def draw(seed, largest=40):
    """Case number ``seed``."""
    rng = np.random.default_rng([2024, seed])
    contacts = int(rng.integers(2, largest + 1)) if rng.random() < 0.5 else int(rng.integers(2, 9))
    bodies = max(1, round(contacts * rng.uniform(0.3, 1.5)))
    most = rng.choice([0.3, 0.8, 1.5])
    mu = np.where(rng.random(contacts) < 0.15, 0.0, rng.uniform(0.05, most, contacts))
    J = rows(rng, contacts, bodies, mu)
    G = J @ J.T
    tangent = np.flatnonzero(mu)
    planted = bool(rng.random() < 0.6)
    if planted:
        s = scales(G, contacts, tangent)
        state = rng.choice(4, size=contacts, p=[0.35, 0.35, 0.15, 0.15])  # open, sticking, sliding forth, back
        verge = rng.random(contacts) < 0.1
        p = np.where((state == 0) | verge, 0.0, rng.exponential(1.0, contacts)) * s
        v = np.where((state == 0) & ~verge, rng.exponential(1.0, contacts), 0.0) / s
        share = np.select([state == 2, state == 3], [-1.0, 1.0], rng.uniform(-1, 1, contacts))
        slip = np.select([state == 1, state == 2, state == 3], [0.0, 1.0, -1.0], rng.standard_normal(contacts))
        slip = slip * np.where(state > 1, rng.exponential(1.0, contacts), 1.0) / s
        force = np.concatenate([p, (share * mu * p)[tangent]])
        free = np.concatenate([v, slip[tangent]]) - G @ force
    else:
        free = J @ rng.standard_normal(J.shape[1])
    a, b = rng.uniform(-15, 15), rng.uniform(-6, 6)
    return Case(G * 10.0**-a, free * 10.0**b, mu, planted, a, b)


def judged(problem, z, number=np.longdouble):
    """The certified residual of z in its two sizes, in ``number`` (longdouble or Fraction), from the definition."""
    exact = number is Fraction
    convert = np.vectorize(Fraction, otypes=[object]) if exact else (lambda x: np.asarray(x, dtype=number))
    mu, tangent, n = problem.friction, np.flatnonzero(problem.friction), len(problem.friction)
    m = n + len(tangent)
    s = scales(problem.delassus, n, tangent)
    s = convert(s)
    S = np.concatenate([s, s[tangent]])
    G = convert(problem.delassus) * S * S[:, None]
    free, mus = convert(problem.free) * S, convert(mu)
    z = convert(z)
    p, right, left = z[:n] / s, z[n:m] / s[tangent], z[m:] * s[tangent]
    edge = (mus * p)[tangent]
    columns = G[:, :n].copy()  # the columns of lambda_N in the three-unknown form
    columns[:, tangent] = columns[:, tangent] - G[:, n:] * mus[tangent]
    w = G @ np.concatenate([p, right - edge]) + free
    w[n:] = w[n:] + left
    last = edge + edge - right
    row = np.maximum(abs(columns).max(axis=1), abs(G[:, n:]).max(axis=1) if len(tangent) else 0)
    row[n:] = np.maximum(row[n:], 1)
    row = np.where(row == 0, 1, row)
    terms = abs(columns) @ abs(p) + (abs(G[:, n:]) @ abs(right) if len(tangent) else 0) + abs(free)
    terms[n:] = terms[n:] + abs(left)
    wrong = abs(np.minimum(row * np.concatenate([p, right]), w))
    load = abs(free)
    if len(tangent):
        lift = np.maximum(2 * mus[tangent], 1)
        wrong = np.concatenate([wrong, abs(np.minimum(lift * left, last))])
        terms = np.concatenate([terms, 2 * abs(edge) + abs(right)])
    largest = max(load, default=0)
    sizes = [
        sizes_of(*(max(values[rows]) for values in (wrong, terms)), max(load[rows[:2]]), largest)
        for k, rows in enumerate(rows_of_contacts(mu))
    ]
    return tuple(max(each) for each in zip(*sizes, strict=True))


def rows_of_contacts(mu):
    """The rows of each contact in the form of three unknowns: normal, tangent, bound."""
    n, tangent = len(mu), np.flatnonzero(mu).tolist()
    rows = [[k] for k in range(n)]
    for j, k in enumerate(tangent):
        rows[k] += [n + j, n + len(tangent) + j]
    return rows


def sizes_of(wrong, terms, load, all_else):
    """What a contact misses relative to its terms, guarded, and to its load, by the definition."""
    if wrong == 0 and ROUNDING * terms <= GUARD * load:
        return 0.0, 0.0
    own = max(load, min(terms, all_else))
    if own == 0:
        return (0.0, 0.0) if wrong == 0 else (np.inf, np.inf)
    strict = float(wrong / own)
    size = max(terms, own)
    residual = strict if wrong > GUARD * own else float(wrong / size)
    return max(residual, float(ROUNDING * size / own) if ROUNDING * size > GUARD * own else 0.0), strict


def moved(problem, force):
    """G lambda + free in units in which the contacts are alike, and the largest of the terms of which it is made."""
    n, tangent = len(problem.friction), np.flatnonzero(problem.friction)
    s = scales(problem.delassus, n, tangent)
    S = np.concatenate([s, s[tangent]])
    terms = (np.abs(problem.delassus) @ np.abs(force) + np.abs(problem.free)) * S
    return (problem.delassus @ force + problem.free) * S, terms.max(initial=0.0)
