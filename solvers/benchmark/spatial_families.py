"""Contact problems in space: planted answers, redundant supports, piles, jaws, contacts with three solutions.

As in the plane a solution exists where ``free`` is J u, J the rows of the contacts and u velocities of the bodies:
forces within the friction cones that leave all bodies at rest have no power on it (Acary, Cadoux, Lemarechal & Malick
2011). Each family is a function of a random generator and of a number of contacts; those that name no source are built
here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.benchmark.example import Example
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Status

__all__ = ["cone_jaws", "cone_piles", "floor_boxes", "planted_cones", "pucks", "three_solutions"]

Rng = np.random.Generator
INVERSE = np.array([1.0, 1.0, 1.0, 6.0, 9.0, 12.0])  # masses and inertias of a body of 1 kg

# A block, free velocity and coefficient of one contact that has three solutions: it sticks, or slides in two ways.
THREE = (((0.33, 0.58, -0.09), (0.58, 3.8, -4.15), (-0.09, -4.15, 6.7)), (-0.017, -0.65, 1.1), 3.6)


def contact_rows(place: FloatArray, normal: FloatArray) -> FloatArray:
    """Rows (3, 6) of normal and two tangents at a place (3,) of a body, on (v, omega) of its mass centre."""
    n = normal / np.linalg.norm(normal)
    first = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    first /= np.linalg.norm(first)
    axes = np.array([n, first, np.cross(n, first)])
    return np.hstack([axes, np.cross(place, axes)])


def _problem(rows: FloatArray, inverse: FloatArray, velocity: FloatArray, mu: FloatArray) -> SpatialContactProblem:
    """Of rows (3 k, d), diagonal masses (d,) and velocities (d,) without contact forces."""
    factor = rows * np.sqrt(inverse)
    return SpatialContactProblem(factor @ factor.T, rows @ velocity, mu, factor=factor)


def _example(name: str, problem: SpatialContactProblem) -> Example:
    return Example(f"{name}, mu <= {problem.friction.max():.3g}", problem, "cone", Status.SOLVED)


def _coefficients(rng: Rng, n: int, largest: float) -> FloatArray:
    """(n,) coefficients up to ``largest``, all different, some of them zero."""
    return largest * np.where(rng.random(n) < 0.15, 0.0, rng.uniform(0.05, 1.0, n))


def planted_cones(rng: Rng, n: int) -> Iterator[Example]:
    """Full-rank G and ``free`` from drawn forces and velocities: each contact open, sticking or sliding."""
    for largest in (0.5, 2.0):
        rows = rng.standard_normal((3 * n, 3 * n + 2))
        mu, state = _coefficients(rng, n, largest), rng.integers(3, size=n)
        angle, size, speed = rng.uniform(0.0, 2.0 * np.pi, n), rng.uniform(0.1, 1.0, n), rng.uniform(0.1, 1.0, n)
        away = np.column_stack([np.cos(angle), np.sin(angle)])
        pressed, slides = np.where(state > 0, size, 0.0), (state == 2) | (mu == 0.0)
        share = np.where(slides, 1.0, rng.uniform(0.0, 0.9, n)) * mu * pressed
        r = np.column_stack([pressed, -share[:, None] * away]).ravel()
        slip = np.where(slides | (state == 0), speed, 0.0)
        u = np.column_stack([np.where(state == 0, size, 0.0), slip[:, None] * away]).ravel()
        free = u - rows @ (rows.T @ r)
        problem = SpatialContactProblem(rows @ rows.T, free, mu, factor=rows)
        yield Example(f"planted cones {n}, mu <= {largest:g}", problem, "cone", Status.SOLVED, r)


def pucks(rng: Rng, n: int) -> Iterator[Example]:
    """A disc on n >= 3 feet: at rest, sliding, spinning, rolling over one foot; six rows are independent at most."""
    count = max(3, n)
    angle = 2.0 * np.pi * np.arange(count) / count
    feet = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), np.full(count, -0.2)])
    up = np.array([0.0, 0.0, 1.0])
    rows = np.vstack([contact_rows(foot, up) for foot in feet])
    inverse = np.array([1.0, 1.0, 1.0, 300.0, 300.0, 200.0])
    for name, velocity in (
        ("falling", (0.0, 0.0, -0.1, 0.0, 0.0, 0.0)),
        ("sliding", (1.0, 0.5, -0.1, 0.0, 0.0, 0.0)),
        ("spinning", (0.3, 0.0, -0.1, 0.0, 0.0, 20.0)),
        ("tilting", (0.2, -0.1, -0.1, 3.0, -2.0, 1.0)),
    ):
        for mu in (0.0, 0.2, 1.5):
            yield _example(f"{name} puck {count}", _problem(rows, inverse, np.array(velocity), np.full(count, mu)))
    mixed = _coefficients(rng, count, 1.0)
    yield _example(f"puck of many coefficients {count}", _problem(rows, inverse, rng.standard_normal(6), mixed))


def floor_boxes(rng: Rng, n: int) -> Iterator[Example]:
    """Towers of boxes on four points each, the top box up to 100 times heavier; unsettled a little."""
    count = max(1, n // 4)
    up = np.array([0.0, 0.0, 1.0])
    corners = np.array([[x, y, -0.5] for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
    rows = np.zeros((12 * count, 6 * count))
    for b in range(count):
        for c, corner in enumerate(corners):
            place = slice(3 * (4 * b + c), 3 * (4 * b + c) + 3)
            rows[place, 6 * b : 6 * b + 6] = contact_rows(corner, up)
            if b:
                rows[place, 6 * b - 6 : 6 * b] = -contact_rows(corner * [1.0, 1.0, -1.0], up)
    for ratio in (1.0, 100.0):
        mass = np.ones(count)
        mass[-1] = ratio
        inverse = np.tile(INVERSE, count) / np.repeat(mass, 6)
        falling = np.tile([0.0, 0.0, -0.01, 0.0, 0.0, 0.0], count)
        for size in (0.0, 0.01):
            moved = falling + size * rng.standard_normal(6 * count)
            problem = _problem(rows, inverse, moved, np.full(4 * count, 0.5))
            yield _example(f"tower {count}, ratio {ratio:g}, moved by {size:g}", problem)


def cone_piles(rng: Rng, n: int) -> Iterator[Example]:
    """Contacts at random points between few bodies, or with the ground: both G and the forces are far from unique."""
    bodies = max(1, n // 3)
    rows = np.zeros((3 * n, 6 * bodies))
    for k in range(n):
        first = int(rng.integers(bodies))
        others = [] if rng.random() < 0.3 else [b for b in range(bodies) if b != first]
        normal = rng.standard_normal(3)
        place, other = rng.uniform(-1.0, 1.0, (2, 3))
        rows[3 * k : 3 * k + 3, 6 * first : 6 * first + 6] = contact_rows(place, normal)
        if others:
            second = int(rng.choice(others))
            rows[3 * k : 3 * k + 3, 6 * second : 6 * second + 6] = -contact_rows(other, normal)
    mass = 10.0 ** rng.uniform(-0.5, 0.5, bodies)
    inverse, velocity = np.tile(INVERSE, bodies) / np.repeat(mass, 6), rng.standard_normal(6 * bodies)
    for largest in (0.0, 0.3, 1.0):
        mu = _coefficients(rng, n, largest)
        yield _example(f"pile of {bodies} bodies {n}", _problem(rows, inverse, velocity, mu))


def three_solutions(rng: Rng, n: int) -> Iterator[Example]:
    """n contacts that do not act on each other and have three solutions each, turned at random about their normals."""
    W, q = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for k in range(n):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        turn = np.eye(3)
        turn[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        place = slice(3 * k, 3 * k + 3)
        W[place, place] = turn @ np.array(THREE[0]) @ turn.T
        q[place] = turn @ np.array(THREE[1])
    problem = SpatialContactProblem(W, q, np.full(n, THREE[2]))
    yield Example(f"three solutions each {n}", problem, "cone", Status.NOT_UNIQUE)


def cone_jaws(rng: Rng, n: int) -> Iterator[Example]:
    """Bodies between contacts that face each other and both close: no motion opens both, whatever the friction."""
    k = max(1, n // 2)
    rows = np.zeros((6 * k, 6 * k))
    for b in range(k):
        own = contact_rows(rng.uniform(-1.0, 1.0, 3), rng.standard_normal(3))
        rows[6 * b : 6 * b + 3, 6 * b : 6 * b + 6] = own
        rows[6 * b + 3 : 6 * b + 6, 6 * b : 6 * b + 6] = own * [[-1.0], [-1.0], [1.0]]
    factor = rows * np.sqrt(np.tile(INVERSE, k))
    free = np.tile([-1.0, 0.1, 0.0], 2 * k)
    mu = _coefficients(rng, 2 * k, 0.5)
    problem = SpatialContactProblem(factor @ factor.T, free, mu, factor=factor)
    yield Example(f"jaws {2 * k}", problem, "cone", Status.INFEASIBLE)
