"""Towers and heaps of planar bodies as sparse factors, free velocities and friction: contact problems of any size.

Bodies have unit size; ``free`` are their contact velocities after a step of gravity, scaled as the masses are.
"""

import numpy as np
import scipy.sparse

SPEED = 9.81e-3  # of a step of 1 ms


def factor_of(contacts, bodies, mass, inertia):
    """J (2 n, 3 bodies), rows [normals; tangents], of contacts (first body or -1, second body, arms, normal)."""
    rows, columns, values = [], [], []
    n = len(contacts)
    for k, (first, second, arm, other, normal) in enumerate(contacts):
        tangent = (-normal[1], normal[0])
        for row, (x, y) in ((k, normal), (n + k, tangent)):
            for body, (a, b), sign in ((second, arm, 1.0), (first, other, -1.0)):
                if body < 0:
                    continue
                parts = (x / np.sqrt(mass[body]), y / np.sqrt(mass[body]), (a * y - b * x) / np.sqrt(inertia[body]))
                rows += [row] * 3
                columns += [3 * body + i for i in range(3)]
                values += [sign * part for part in parts]
    return scipy.sparse.csr_array((values, (rows, columns)), shape=(2 * n, 3 * bodies))


def pile_of(contacts, mass, inertia, friction, push=0.0):
    """Factor, free velocities and friction of bodies that fall, and are pushed to the right."""
    J = factor_of(contacts, len(mass), mass, inertia)
    u = np.zeros(3 * len(mass))
    u[1::3] = -SPEED * np.sqrt(mass)
    u[0::3] = push * SPEED * np.sqrt(mass)
    return J, J @ u, np.full(len(contacts), friction)


def columns(count, height, friction=0.5, ratio=1.0, push=0.0):
    """So many towers of boxes side by side, two contacts a box; the mass grows by ``ratio`` from bottom to top."""
    mass = np.tile(np.geomspace(1.0, ratio, height), count)
    contacts = []
    for i in range(count * height):
        below = -1 if i % height == 0 else i - 1
        contacts += [(below, i, (x, -0.5), (x, 0.5), (0.0, 1.0)) for x in (-0.5, 0.5)]
    return pile_of(contacts, mass, mass / 6.0, friction, push)


def heap(rows, width, friction=0.5, ratio=1.0, seed=0):
    """Discs in a triangular lattice on a floor between walls, radii alike, masses at random up to ``ratio``."""
    rng = np.random.default_rng(seed)
    number, place = {}, []
    for j in range(rows):
        for i in range(width - j % 2):
            number[j, i] = len(place)
            place.append((i + 0.5 * (j % 2), j * np.sqrt(0.75)))
    contacts = []
    for (j, i), k in number.items():
        x = place[k]
        if j == 0:
            contacts.append((-1, k, (0.0, -0.5), (0.0, 0.0), (0.0, 1.0)))
        if j % 2 == 0 and i in (0, width - 1):
            side = 1.0 if i == 0 else -1.0
            contacts.append((-1, k, (-0.5 * side, 0.0), (0.0, 0.0), (side, 0.0)))
        for other in ((j - 1, i), (j - 1, i + (1 if j % 2 else -1)), (j, i - 1)):
            if other in number:
                y = place[number[other]]
                normal = (x[0] - y[0], x[1] - y[1])
                arm = (-0.5 * normal[0], -0.5 * normal[1])
                contacts.append((number[other], k, arm, (-arm[0], -arm[1]), normal))
    mass = ratio ** rng.random(len(place))
    return pile_of(contacts, mass, mass / 8.0, friction)


def shuffled(pile, seed):
    """The same contacts in another order."""
    J, free, mu = pile
    order = np.random.default_rng(seed).permutation(len(mu))
    rows = np.concatenate([order, len(mu) + order])
    return J[rows], free[rows], mu[order]


def moving(pile, size, seed):
    """The same bodies, with velocities at random, ``size`` times those that they fall with."""
    J, free, mu = pile
    return J, free + J @ (size * SPEED * np.random.default_rng(seed).standard_normal(J.shape[1])), mu
