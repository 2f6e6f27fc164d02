"""Piles for tests of large contact problems: discs and boxes in rows of body velocities, and random islands."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from lcpflex.jit.struct import allocate
from lcpflex.solvers import ContactProblem
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory, grown, large_memory
from lcpflex.solvers.contact.large.solving import ROOM, solve_large

FloatArray = npt.NDArray[np.float64]
STEP, GRAVITY = 1e-3, 9.81


@dataclass
class Island:
    """Rows r = 0, 1 of contact k: normal 2 k and tangent 2 k + 1; then joint rows. Blocks are white: A = 1."""

    white: FloatArray  # (rows, 2, width)
    row_body: npt.NDArray[np.int64]
    size: npt.NDArray[np.int64]  # velocities of each body
    free: FloatArray
    friction: FloatArray
    terms: FloatArray
    p: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if not len(self.p):
            self.p = np.zeros(len(self.free))

    @property
    def dof(self) -> npt.NDArray[np.int64]:
        return np.concatenate([[0], np.cumsum(self.size)])

    @property
    def jacobian(self) -> FloatArray:
        """J (rows, unknowns), dense."""
        J, dof = np.zeros((len(self.free), self.dof[-1])), self.dof
        for r, i in zip(*np.nonzero(self.row_body >= 0), strict=True):
            b = self.row_body[r, i]
            J[r, dof[b] : dof[b + 1]] += self.white[r, i, : self.size[b]]  # zeros beyond
        return J

    def problem(self) -> BodyContacts:
        """The same for the solver; its answer goes to ``p``."""
        n = len(self.friction)
        return allocate(
            BodyContacts,
            {},
            n_contacts=n,
            n_joints=len(self.free) - 2 * n,
            n_bodies=len(self.size),
            first_contact=0,
            white=self.white,
            row_body=self.row_body,
            dof=self.dof,
            free=self.free,
            terms=self.terms,
            p=self.p,
            normal_row=2 * np.arange(n),
            tangent_row=np.where(self.friction > 0.0, 2 * np.arange(n) + 1, -1),
            friction=self.friction,
            joint_row=np.arange(2 * n, len(self.free)),
            bodies=np.arange(len(self.size)),
            slip=np.zeros(0),
        )

    def contact_problem(self) -> ContactProblem:
        """The same with a dense Delassus operator; joints condensed."""
        n = len(self.friction)
        J, joints = self.jacobian, slice(2 * n, None)
        rows = np.concatenate([2 * np.arange(n), 2 * np.flatnonzero(self.friction) + 1])
        back = np.linalg.pinv(J[joints] @ J[joints].T)
        free = self.free - J @ (J[joints].T @ (back @ self.free[joints]))
        held = J @ (np.eye(J.shape[1]) - J[joints].T @ back @ J[joints])
        return ContactProblem(None, free[rows], self.friction, factor=held[rows])

    def solve(self, memory: LargeMemory | None = None, **limits: float) -> tuple[int, LargeMemory]:
        """Status, and the memory that tells the rest."""
        problem = self.problem()
        if memory is None:
            units = len(self.friction) + problem.n_joints
            memory = large_memory(len(self.size), units, len(self.size), self.white.shape[2], 2)
        for name, value in limits.items():
            setattr(memory.judged if name == "tolerance" else memory.search, name, value)
        while (status := solve_large(problem, memory, PLANAR)) == ROOM:
            memory = grown(memory, {})
        return status, memory

    def residual(self) -> float:
        """Of p, beside the largest free velocity or 1e-3 of its terms, each contact in its own units."""
        J, n = self.jacobian, len(self.friction)
        v = self.free + J @ (J.T @ self.p)
        square = (J**2).sum(axis=1)
        pairs = np.repeat(square[2 * n :].reshape(-1, 2).max(axis=1), 2)  # two joint rows of the same bodies
        unit = np.sqrt(np.maximum(square[: 2 * n : 2], square[1 : 2 * n : 2] * (self.friction > 0.0)))
        y, q = v[: 2 * n].reshape(-1, 2) / unit[:, None], self.p[: 2 * n].reshape(-1, 2) * unit[:, None]
        bound = self.friction * np.maximum(q[:, 0], 0.0)
        normal = np.abs(np.minimum(q[:, 0], y[:, 0]))
        tangent = np.where(self.friction > 0.0, np.abs(q[:, 1] - np.clip(q[:, 1] - y[:, 1], -bound, bound)), 0.0)
        joint = np.abs(v[2 * n :])
        joint /= np.sqrt(pairs)
        sizes = np.concatenate(
            [
                np.abs(self.free[: 2 * n].reshape(-1, 2) / unit[:, None])[:, 0],
                (np.abs(self.free[1 : 2 * n : 2]) / unit)[self.friction > 0.0],
                1e-3 * (self.terms[: 2 * n].reshape(-1, 2) / unit[:, None]).ravel(),
                np.abs(self.free[2 * n :]) / np.sqrt(pairs),
            ]
        )
        return float(np.concatenate([normal, tangent, joint]).max(initial=0.0) / sizes.max(initial=0.0))


@dataclass
class Touching:
    """Contacts of rigid bodies: body[:, 0] is pushed along n at its point a, body[:, 1] (-1: ground) the other way."""

    body: npt.NDArray[np.int64]
    n: FloatArray
    a: FloatArray  # (k, 2) from the centre of mass
    b: FloatArray
    gap: FloatArray

    def rows(self) -> tuple[FloatArray, npt.NDArray[np.int64]]:
        """(2 k, 2, 3) in velocities of the bodies, and their bodies (2 k, 2)."""
        rows = np.zeros((2 * len(self.n), 2, 3))
        tangent = np.stack([-self.n[:, 1], self.n[:, 0]], axis=1)
        for r, d in enumerate((self.n, tangent)):
            for i, (arm, sign) in enumerate(((self.a, 1.0), (self.b, -1.0))):
                turn = arm[:, 0] * d[:, 1] - arm[:, 1] * d[:, 0]
                rows[r::2, i] = sign * np.column_stack([d, turn]) * (self.body[:, i] >= 0)[:, None]
        return rows, np.repeat(self.body, 2, axis=0)


def island(touching: Touching, mass: FloatArray, inertia: FloatArray, u: FloatArray, friction: float) -> Island:
    """The problem of a step of gravity from the velocities u (bodies, 3)."""
    rows, row_body = touching.rows()
    free_u = np.vstack([u - [0.0, GRAVITY * STEP, 0.0], np.zeros((1, 3))])
    products = rows * free_u[row_body]
    free = products.sum(axis=(1, 2))
    free[::2] += np.maximum(touching.gap, 0.0) / STEP
    root = np.vstack([np.sqrt(np.column_stack([mass, mass, inertia])), np.ones((1, 3))])
    return Island(
        rows / root[row_body],
        row_body,
        np.full(len(mass), 3),
        free,
        np.full(len(touching.gap), friction),
        np.abs(products).sum(axis=(1, 2)),
    )


def brick_wall(rows: int, columns: int, friction: float = 0.5, seed: int = 0, motion: float = 0.0) -> Island:
    """Bricks in a stretcher bond; the corners of each on the faces of those above and below. Towers: one column."""
    w, h = 0.2, 0.1
    body, places, ends = [], [], []
    for r in range(rows):
        for c in range(columns):
            own, x = r * columns + c, (c + 0.5 * (r % 2)) * w
            for side in (-0.5, 0.5):
                if r == 0:
                    body.append((own, -1))
                    places.append((side * w, -0.5 * h))
                    ends.append((0.0, 0.0))
                    continue
                for below in range(columns):
                    shift = x - (below + 0.5 * ((r - 1) % 2)) * w
                    if abs(shift) < 0.9 * w:  # ends of the overlap
                        at = side * (w - abs(shift)) - 0.5 * shift
                        body.append((own, own - columns + below - c))
                        places.append((at, -0.5 * h))
                        ends.append((at + shift, 0.5 * h))
    k, mass = len(body), np.full(rows * columns, 1000.0 * w * h)
    rng = np.random.default_rng(seed)
    touching = Touching(np.array(body), np.tile([0.0, 1.0], (k, 1)), np.array(places), np.array(ends), np.zeros(k))
    u = motion * rng.normal(size=(len(mass), 3)) * [1.0, 1.0, 5.0]
    return island(touching, mass, mass * (w**2 + h**2) / 12.0, u, friction)


class Heap:
    """Discs that fall between walls, stepped with time-stepping of step STEP."""

    def __init__(
        self, n: int, width: float, seed: int, scatter: float = 0.02, ratio: float = 1.0, friction: float = 0.5
    ):
        rng = np.random.default_rng(seed)
        self.width, self.friction = width, friction
        self.r = 0.05 * (1.0 + scatter * rng.uniform(-1.0, 1.0, n))
        columns = max(1, int((width - 0.1) // 0.11))
        row, column = np.divmod(np.arange(n), columns)
        x = 0.055 + 0.11 * column + 0.025 * (row % 2) + 1e-3 * rng.uniform(-1.0, 1.0, n)
        self.q = np.column_stack([np.clip(x, self.r, width - self.r), 0.0525 + 0.105 * row, np.zeros(n)])
        self.u = np.zeros((n, 3))
        self.mass = 1000.0 * np.pi * self.r**2 * ratio ** rng.uniform(0.0, 1.0, n)
        self.kept: dict[tuple[int, int], FloatArray] = {}
        self.memory: LargeMemory | None = None
        self.island: Island | None = None

    def touching(self) -> Touching:
        x, r, n = self.q[:, :2], self.r, len(self.r)
        i, j = np.triu_indices(n, 1)
        d = x[i] - x[j]
        far = np.hypot(*d.T)
        near = far - r[i] - r[j] < 1e-5
        i, j, d, far = i[near], j[near], d[near], far[near]
        body, normal, gap = [np.column_stack([i, j])], [d / far[:, None]], [far - r[i] - r[j]]
        for wall, (direction, distance) in enumerate(
            (((0.0, 1.0), x[:, 1]), ((1.0, 0.0), x[:, 0]), ((-1.0, 0.0), self.width - x[:, 0]))
        ):
            k = np.flatnonzero(distance - r < 1e-5)
            body.append(np.column_stack([k, np.full(len(k), -1 - wall)]))
            normal.append(np.tile(direction, (len(k), 1)))
            gap.append(distance[k] - r[k])
        pairs, n_, g = np.concatenate(body), np.concatenate(normal), np.concatenate(gap)
        self.keys = [(int(a), int(b)) for a, b in pairs]
        return Touching(
            np.maximum(pairs, -1), n_, -n_ * r[pairs[:, 0]][:, None], n_ * r[np.maximum(pairs[:, 1], 0)][:, None], g
        )

    def step(self) -> int:
        """One step; the status of its contact problem, 0 without one."""
        touching, status = self.touching(), 0
        du = np.zeros((len(self.r) + 1, 3))
        inertia = 0.5 * self.mass * self.r**2
        if len(touching.gap):
            self.island = island(touching, self.mass, inertia, self.u, self.friction)
            self.island.p[:] = np.concatenate([self.kept.get(key, np.zeros(2)) for key in self.keys])
            if self.memory is None:
                self.memory = large_memory(len(self.r), 4 * len(self.r), len(self.r), 3, 2)
            status, self.memory = self.island.solve(self.memory)
            for i in range(2):
                np.add.at(du, self.island.row_body[:, i], self.island.white[:, i] * self.island.p[:, None])
            self.kept = dict(zip(self.keys, self.island.p.reshape(-1, 2).copy(), strict=True))
        self.u = self.u - [0.0, GRAVITY * STEP, 0.0]
        self.u += du[:-1] / np.sqrt(np.column_stack([self.mass, self.mass, inertia]))
        self.q = self.q + STEP * self.u
        return status


def random_island(
    seed: int, bodies: int, contacts: int, joints: int = 0, friction: float = 0.5, sizes: tuple[int, int] = (3, 4)
) -> Island:
    """Rows of random numbers between random bodies of ``sizes`` (first, last + 1) velocities; joints by the pair."""
    rng = np.random.default_rng(seed)
    size = rng.integers(*sizes, bodies)
    rows = 2 * (contacts + joints)
    pairs = rng.integers(-1, bodies, (contacts + joints, 2))
    pairs[pairs[:, 0] == pairs[:, 1], 1] = -1
    pairs[(pairs < 0).all(axis=1), 0] = 0
    row_body = np.repeat(pairs, 2, axis=0)
    white = rng.normal(size=(rows, 2, int(size.max())))
    white[row_body < 0] = 0.0
    for r, i in zip(*np.nonzero(row_body >= 0), strict=True):
        white[r, i, size[row_body[r, i]] :] = 0.0
    u = rng.normal(size=(bodies + 1, size.max()))
    u[-1] = 0.0
    products = white * u[row_body]
    return Island(
        white, row_body, size, products.sum(axis=(1, 2)), np.full(contacts, friction), np.abs(products).sum(axis=(1, 2))
    )


def permuted(source: Island, seed: int) -> tuple[Island, npt.NDArray[np.int64]]:
    """Contacts and bodies in another order; where each row comes from."""
    rng = np.random.default_rng(seed)
    n = len(source.friction)
    contacts, bodies = rng.permutation(n), rng.permutation(len(source.size))
    rows = np.concatenate([(2 * contacts[:, None] + [0, 1]).ravel(), np.arange(2 * n, len(source.free))])
    number = np.append(np.argsort(bodies), -1)
    return (
        replace(
            source,
            white=source.white[rows],
            row_body=number[source.row_body[rows]],
            size=source.size[bodies],
            free=source.free[rows],
            friction=source.friction[contacts],
            terms=source.terms[rows],
            p=np.zeros(len(rows)),
        ),
        rows,
    )
