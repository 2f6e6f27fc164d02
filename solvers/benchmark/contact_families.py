"""Contact problems of planar bodies: redundant supports, mass ratios, large friction, Painleve's rods, flexible bars.

Where ``free`` is J u, J the rows of the contacts and u the velocities (or accelerations) of the bodies, a solution
exists: forces within the friction cones that leave all bodies at rest, J^T lambda = 0, have no power on it,
lambda.J u = 0, which is the condition of Anitescu & Potra (1997). It stays true if normal velocities are raised.

Each family is a function of a random generator and of a number of contacts. Those that name no source are built here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.benchmark.example import Example
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.problem import Lcp, Status

__all__ = [
    "bars",
    "boxes",
    "impacting_rods",
    "light_and_heavy",
    "mass_points",
    "piles",
    "planted_contacts",
    "sliding_rods",
    "squeezed",
    "stacks",
    "supported",
    "walls",
]

Rng = np.random.Generator


def _contacts(
    normal: FloatArray,
    tangent: FloatArray,
    inverse_mass: FloatArray,
    velocity: FloatArray,
    mu: FloatArray,
    raised: float | FloatArray = 0.0,
) -> ContactProblem:
    """The problem of rows normal, tangent (n_N, k), diagonal masses (k,) and velocities (k,) without contact forces.

    raised (n_N,): what is added to the normal velocities.
    """
    rows = np.vstack([normal, tangent[mu > 0.0]])
    free = rows @ velocity
    free[: len(normal)] += raised
    factor = rows * np.sqrt(inverse_mass)
    return ContactProblem(factor @ factor.T, free, mu, factor=factor)


def _example(name: str, problem: ContactProblem) -> Example:
    """A solvable example; its motion is unique without friction."""
    rubs = bool(problem.friction.any())
    kind = "friction" if rubs else "symmetric"
    level = f"mu <= {problem.friction.max():.3g}" if rubs else "no friction"
    return Example(f"{name}, {level}", problem, kind, Status.SOLVED, None, "" if rubs else "motion")


def _scene(rng: Rng, bodies: int, contacts: int, ground: float = 0.3) -> tuple[FloatArray, FloatArray]:
    """Rows (contacts, 3 bodies) normal and tangent of contacts at random points between random bodies, or the ground.

    ground: share of contacts with the ground. Lever arms up to 1 m.
    """
    rows = np.zeros((2, contacts, 3 * bodies))
    for k in range(contacts):
        first = int(rng.integers(bodies))
        others = [] if rng.random() < ground else [b for b in range(bodies) if b != first]
        angle = rng.uniform(0.0, 2.0 * np.pi)
        c, s = np.cos(angle), np.sin(angle)
        touching = [(first, 1.0)] + ([(int(rng.choice(others)), -1.0)] if others else [])
        for body, sign in touching:
            x, y = rng.uniform(-1.0, 1.0, 2)
            columns = slice(3 * body, 3 * body + 3)
            rows[0, k, columns] = sign * np.array([c, s, x * s - y * c])
            rows[1, k, columns] = sign * np.array([-s, c, x * c + y * s])
    return rows[0], rows[1]


def _masses(rng: Rng, bodies: int, decades: float) -> FloatArray:
    """(3 bodies,) inverse masses and inertias, 1 / m and 6 / m, masses spread over ``decades`` powers of ten."""
    mass = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades, bodies)
    inverse: FloatArray = np.repeat(1.0 / mass, 3) * np.tile([1.0, 1.0, 6.0], bodies)
    return inverse


def _coefficients(rng: Rng, contacts: int, largest: float) -> FloatArray:
    """(contacts,) coefficients up to ``largest``, all different, some of them zero."""
    return largest * np.where(rng.random(contacts) < 0.15, 0.0, rng.uniform(0.05, 1.0, contacts))


def _box(contacts: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normal rows, tangent rows, inverse masses of a box of 1 kg, 1 m x 0.5 m, with points along its lower side."""
    x, one = np.linspace(-0.5, 0.5, contacts), np.ones(contacts)
    return np.column_stack([0 * x, one, x]), np.column_stack([one, 0 * x, 0.25 * one]), np.array([1.0, 1.0, 9.6])


def mass_points(rng: Rng, n: int) -> Iterator[Example]:
    """Independent mass points that hit a floor: every answer in closed form; one in three exactly on the border."""
    mass, mu = rng.uniform(0.1, 10.0, n), _coefficients(rng, n, 1.5)
    approach, slide = rng.uniform(-1.0, 0.5, n), rng.uniform(-2.0, 2.0, n)
    pressed = mass * np.maximum(-approach, 0.0)
    on_border = rng.random(n) < 1 / 3
    slide[on_border] = (mu * pressed / mass)[on_border]  # friction at its limit just stops the slip
    normal = np.hstack([np.eye(n), np.zeros((n, n))])
    tangent = np.hstack([np.zeros((n, n)), np.eye(n)])
    problem = _contacts(normal, tangent, np.tile(1.0 / mass, 2), np.concatenate([approach, slide]), mu)
    rubbed = np.clip(-mass * slide, -mu * pressed, mu * pressed)[mu > 0.0]
    z = problem.unknowns(pressed, rubbed)
    yield Example(f"mass points {n}", problem, "friction", Status.SOLVED, z, "motion")


def boxes(rng: Rng, n: int) -> Iterator[Example]:
    """A box on n >= 2 collinear points of a floor: at most three rows of G are independent.

    One velocity is that at which friction just stops the box; one is zero, so that all pairs are degenerate.
    """
    normal, tangent, inverse_mass = _box(max(2, n))
    for velocity in ((1.0, -0.1, 0.0), (0.02, -0.1, 0.0), (-0.2, -1.0, -2.0), (0.01, -0.1, 0.3), (0.0, 0.0, 0.0)):
        for mu in (_coefficients(rng, len(normal), 0.0), np.full(len(normal), 0.2), _coefficients(rng, len(normal), 2)):
            yield _example(
                f"box {len(normal)}, {velocity}", _contacts(normal, tangent, inverse_mass, np.array(velocity), mu)
            )


def walls(rng: Rng, n: int) -> Iterator[Example]:
    """A box in a corner and one between two walls, which friction can jam: forces that grow without any motion."""
    normal, tangent, inverse_mass = _box(max(2, n))
    side = np.array([[-1.0, 0.0, y] for y in (-0.25, 0.25)])
    along = np.array([[0.0, 1.0, 0.5], [0.0, 1.0, 0.5]])
    other = side * [-1.0, 1.0, -1.0]
    opposite = along * [1.0, 1.0, -1.0]
    for name, rows, slips in (
        ("corner", [normal, side], [tangent, along]),
        ("slot", [side, other], [along, opposite]),
        ("pit", [normal, side, other], [tangent, along, opposite]),
    ):
        J, T = np.vstack(rows), np.vstack(slips)
        velocity = rng.standard_normal(3) - [0.0, 1.0, 0.0]
        yield _example(f"{name} {len(J)}", _contacts(J, T, inverse_mass, velocity, np.zeros(len(J))))
        yield _example(f"{name} {len(J)}", _contacts(J, T, inverse_mass, velocity, _coefficients(rng, len(J), 2.0)))


def _stack(boxes: int, points: int) -> tuple[FloatArray, FloatArray]:
    """Normal and tangent rows of boxes on top of one another, ``points`` contacts under each."""
    normal, tangent, _ = _box(points)
    N, T = np.zeros((2, boxes * points, 3 * boxes))
    for b in range(boxes):
        rows = slice(b * points, (b + 1) * points)
        N[rows, 3 * b : 3 * b + 3], T[rows, 3 * b : 3 * b + 3] = normal, tangent
        if b:
            N[rows, 3 * b - 3 : 3 * b] = -normal
            T[rows, 3 * b - 3 : 3 * b] = tangent * [-1.0, 1.0, 1.0]  # upper side of the box below
    return N, T


def stacks(rng: Rng, n: int) -> Iterator[Example]:
    """Stacks of boxes, each on redundant points, the top box up to 1e8 times heavier (after Erleben 2007)."""
    points = int(rng.integers(2, 5))
    count = max(1, n // points)
    N, T = _stack(count, points)
    for ratio in (1.0, 1e4, 1e8):
        mass = np.ones(count)
        mass[-1] = ratio
        inverse_mass = np.repeat(1.0 / mass, 3) * np.tile([1.0, 1.0, 9.6], count)
        falling = np.tile([0.0, -0.01, 0.0], count)
        # Every interface stops what is above it; equal shares have no moment about the middle.
        shares = np.repeat(0.01 * np.cumsum(mass[::-1])[::-1] / points, points)
        flat = _contacts(N, T, inverse_mass, falling, np.zeros(len(N)))
        name = f"stack {count} x {points}, ratio {ratio:g}"
        yield Example(f"{name}, no friction", flat, "symmetric", Status.SOLVED, shares, "motion")
        for largest in (0.5, 2.0):
            moved = falling + 0.01 * rng.standard_normal(3 * count)
            yield _example(name, _contacts(N, T, inverse_mass, moved, _coefficients(rng, len(N), largest)))


def piles(rng: Rng, n: int) -> Iterator[Example]:
    """Few bodies with many contacts at random points: both G and the forces are far from unique."""
    bodies = max(1, n // 4)
    N, T = _scene(rng, bodies, n)
    velocity, inverse_mass = rng.standard_normal(3 * bodies), _masses(rng, bodies, 1.0)
    for largest in (0.0, 0.5, 2.0):
        yield _example(
            f"pile {bodies} bodies {n}", _contacts(N, T, inverse_mass, velocity, _coefficients(rng, n, largest))
        )
    copies = np.sort(rng.integers(n, size=n))  # exact copies of a contact, with its coefficient
    mu = _coefficients(rng, n, 1.0)[copies]
    yield _example(f"pile of copies {n}", _contacts(N[copies], T[copies], inverse_mass, velocity, mu))


def light_and_heavy(rng: Rng, n: int) -> Iterator[Example]:
    """Random contacts between as many bodies, of masses spread over eight powers of ten."""
    N, T = _scene(rng, n, n)
    velocity, inverse_mass = rng.standard_normal(3 * n), _masses(rng, n, 8.0)
    for largest in (0.0, 0.5, 2.0):
        yield _example(f"masses 1e8 {n}", _contacts(N, T, inverse_mass, velocity, _coefficients(rng, n, largest)))


def planted_contacts(rng: Rng, n: int) -> Iterator[Example]:
    """Full-rank G and ``free`` from drawn forces and velocities: each contact open, sticking or sliding either way."""
    mu = rng.uniform(0.05, 2.0, n)
    rows = rng.standard_normal((2 * n, 2 * n + 2))
    state = rng.integers(4, size=n)
    size, speed = rng.uniform(0.1, 1.0, (2, n))
    pressed = np.where(state > 0, size, 0.0)
    rubbed = mu * pressed * np.select([state == 2, state == 3], [-1.0, 1.0], rng.uniform(-0.9, 0.9, n))
    slip = np.select([state == 0, state == 2, state == 3], [rng.standard_normal(n), speed, -speed], 0.0)
    G = rows @ rows.T
    forces = np.concatenate([pressed, rubbed])
    free = np.concatenate([np.where(state == 0, size, 0.0), slip]) - G @ forces
    problem = ContactProblem(G, free, mu, factor=rows)
    z = problem.unknowns(pressed, rubbed)
    yield Example(f"planted contacts {n}", problem, "friction", Status.SOLVED, z)


def supported(rng: Rng, n: int) -> Iterator[Example]:
    """Acceleration level: bodies at rest on redundant supports under gravity and random loads, floors that recede."""
    N, T = _stack(max(1, n // 3), 3)
    bodies = N.shape[1] // 3
    inverse_mass = _masses(rng, bodies, 2.0)
    for largest in (0.0, 0.3, 1.0):
        loads = np.tile([0.0, -9.81, 0.0], bodies) + rng.standard_normal(3 * bodies)
        receding = np.where(rng.random(len(N)) < 0.3, rng.uniform(0.0, 5.0, len(N)), 0.0)
        mu = _coefficients(rng, len(N), largest)
        yield _example(f"supported {len(N)}", _contacts(N, T, inverse_mass, loads, mu, receding))


def bars(rng: Rng, n: int) -> Iterator[Example]:
    """Contacts along a flexible bar of 40 modes, stiffness in the implicit step h: singular to rounding for large h."""
    modes = np.arange(1, 41)
    x = np.sort(rng.uniform(0.02, 0.98, n))
    across, along = np.sin(np.pi * np.outer(x, modes)), np.cos(np.pi * np.outer(x, modes))
    N, T = np.hstack([across, 0 * along]), np.hstack([0 * across, along])
    frequency = np.concatenate([20.0 * modes**2, 3e3 * modes])
    velocity = rng.standard_normal(80) * np.tile(np.exp(-modes / 8.0), 2)
    for h in (1e-2, 1e-5):
        inverse_mass = 2.0 / (1.0 + (h * frequency) ** 2)
        for largest in (0.0, 0.8):
            yield _example(f"bar {n}, h {h:g}", _contacts(N, T, inverse_mass, velocity, _coefficients(rng, n, largest)))


def _rods(angle: FloatArray, sled: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows and inverse masses of rods of 1 kg and 1 m that touch with their lower ends; sled: inverse mass below them.

    angle (n,): against the ground. A sled that can move couples the rods.
    """
    n = len(angle)
    N, T = np.zeros((2, n, 3 * n + 2))
    for k in range(n):
        N[k, 3 * k : 3 * k + 3] = [0.0, 1.0, -0.5 * np.cos(angle[k])]
        T[k, 3 * k : 3 * k + 3] = [1.0, 0.0, 0.5 * np.sin(angle[k])]
    N[:, -1], T[:, -2] = -1.0, -1.0
    return N, T, np.concatenate([np.tile([1.0, 1.0, 12.0], n), [sled, sled]])


def impacting_rods(rng: Rng, n: int) -> Iterator[Example]:
    """Painleve's rods (1895) at the level of impulses, where a solution always exists; on the ground or on a sled."""
    for sled in (0.0, 0.5):
        N, T, inverse_mass = _rods(rng.uniform(0.4, 1.4, n), sled)
        velocity = rng.standard_normal(3 * n + 2)
        mu = rng.uniform(0.5, 2.0, n)
        yield _example(f"impacting rods {n}, sled {sled}", _contacts(N, T, inverse_mass, velocity, mu))


def sliding_rods(rng: Rng, n: int) -> Iterator[Example]:
    """Painleve's rods at the level of accelerations (Genot & Brogliato 1999): one, two or no solutions for each.

    Sliding in direction s leaves lambda_N alone, M = G_NN - s mu G_NT. For s = -1 and friction beyond a bound the
    diagonal entry of a rod is negative: two solutions if it would lift off, none if it would not, which the unit
    vector of that rod proves.
    """
    angle = rng.uniform(0.6, 1.3, n)
    N, T, inverse_mass = _rods(angle, 0.0)
    bound = (1.0 + 3.0 * np.cos(angle) ** 2) / (3.0 * np.sin(angle) * np.cos(angle))  # G_NN / |G_NT|
    size = rng.uniform(0.1, 1.0, n)
    load = size * rng.choice([-1.0, 1.0], n)
    M = (N * inverse_mass) @ (N + 0.5 * bound[:, None] * T).T
    z = np.maximum(-load, 0.0) / np.diag(M)
    yield Example(f"rods {n}, one solution", Lcp(M, load), "P", Status.SOLVED, z, "z")
    tumbling = rng.random(n) < 0.5
    tumbling[int(rng.integers(n))] = True
    mu = bound * np.where(tumbling, 1.5, 0.5)
    M = (N * inverse_mass) @ (N + mu[:, None] * T).T
    load = np.where(tumbling, size, -size)
    z = np.maximum(-load, 0.0) / np.diag(M)
    yield Example(f"rods {n}, 2^{tumbling.sum()} solutions", Lcp(M, load), "general", Status.NOT_UNIQUE, z)
    unit = np.eye(n)[int(np.argmax(tumbling))]
    yield Example(f"rods {n}, no solution", Lcp(M, -size), "general", Status.INFEASIBLE, certificate=unit)
    N, T, inverse_mass = _rods(angle, 0.2)
    coupled = (N * inverse_mass) @ (N + mu[:, None] * T).T
    yield Example(f"rods {n} on a sled", Lcp(coupled, rng.uniform(-1.0, 1.0, n)), "general", None)


def squeezed(rng: Rng, n: int) -> Iterator[Example]:
    """Bodies held between contacts that face each other and both approach: no motion can open both, with any friction.

    The normal forces of such a pair hold each other and their power is negative, in both forms of the friction problem.
    """
    k = max(1, n // 2)
    half, along = _scene(rng, k, k)
    N, T = np.vstack([half, -half]), np.vstack([along, -along])
    inverse_mass, velocity = _masses(rng, k, 1.0), rng.standard_normal(3 * k)
    for largest in (0.0, 1.0):
        problem = _contacts(N, T, inverse_mass, velocity, _coefficients(rng, 2 * k, largest), -1.0)
        u = np.zeros(problem.size)
        u[: 2 * k] = 1.0
        kind = "friction" if problem.friction.any() else "symmetric"
        yield Example(f"squeezed {2 * k}, mu <= {largest:g}", problem, kind, Status.INFEASIBLE, certificate=u)
