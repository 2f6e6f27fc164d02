"""The arrow inertia against dense linear algebra, and its forces against the Lagrangian they come from."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces, stored_energies
from lcpflex.dynamics.inertia import Arrow, arrow, factorise, multiply, solve_block
from lcpflex.dynamics.whitening import whiten_rows
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Bodies, Loads, frozen

RNG = np.random.default_rng(7)


@pytest.fixture(autouse=True)
def numbers_of_its_own() -> None:
    """Each test draws from the beginning: the same numbers alone and after others."""
    RNG.bit_generator.state = np.random.default_rng(7).bit_generator.state


def random_bodies(modes: tuple[int, ...], stiffened: tuple[int, ...] = (), shortened: tuple[int, ...] = ()) -> Bodies:
    """Bodies whose integrals come from point masses, so that every matrix is a possible one.

    Some are stiffened by spin; some shorten as they bend: their first and last mode is axial, the others bend.
    """
    geometric, geometric_start = [np.zeros(0)], [0]
    fields: dict[str, list[FloatArray]] = {name: [] for name in ("S", "a", "c", "coupling", "stiffness", "damping")}
    mass, inertia, moment, starts = [], [], [], [0]
    for n in modes:
        places = RNG.normal(size=(40, 2))
        weights = RNG.uniform(0.5, 1.0, 40)
        shapes = RNG.normal(size=(80, n)) if n else np.zeros((80, 0))
        shapes, _ = np.linalg.qr(np.sqrt(np.repeat(weights, 2))[:, None] * shapes)
        phi = (shapes / np.sqrt(np.repeat(weights, 2))[:, None]).reshape(40, 2, n)
        turned = np.stack([-places[:, 1], places[:, 0]], axis=1)
        mass.append(weights.sum())
        inertia.append(weights @ (places**2).sum(axis=1))
        moment.append(weights @ places)
        fields["S"].append(np.einsum("p,pik->ki", weights, phi))
        fields["a"].append(np.einsum("p,pik,pi->k", weights, phi, places))
        fields["c"].append(np.einsum("p,pik,pi->k", weights, phi, turned))
        d = np.einsum("p,pk,pl->kl", weights, phi[:, 1], phi[:, 0]) - np.einsum(
            "p,pk,pl->kl", weights, phi[:, 0], phi[:, 1]
        )
        fields["coupling"].append(-d.ravel())
        starts.append(starts[-1] + n * n)
        fields["stiffness"].append(RNG.uniform(1.0, 9.0, n))
        fields["damping"].append(RNG.uniform(0.0, 0.1, n))
    for b, n in enumerate(modes):
        half = 0.2 * RNG.normal(size=(n, n)) if b in stiffened else np.zeros((0, 0))
        geometric.append((half + half.T).ravel())
        geometric_start.append(geometric_start[-1] + half.size)
    ends = [[0, n - 1] if b in shortened else [] for b, n in enumerate(modes)]
    middles = [range(1, n - 1) if b in shortened else [] for b, n in enumerate(modes)]
    halves = [0.5 * RNG.normal(size=(len(a), len(c), len(c))) for a, c in zip(ends, middles, strict=True)]
    matrices = [(half + half.transpose(0, 2, 1)).ravel() for half in halves]
    joined = {name: np.concatenate(parts) for name, parts in fields.items()}
    dof = np.concatenate([[0], np.cumsum([3 + n for n in modes])])
    return Bodies(
        dof=frozen(dof, np.int64),
        mass=frozen(mass),
        inertia=frozen(inertia),
        moment=frozen(moment, columns=2),
        S=frozen(joined["S"], columns=2),
        a=frozen(joined["a"]),
        c=frozen(joined["c"]),
        stiffness=frozen(joined["stiffness"]),
        damping=frozen(joined["damping"]),
        coupling_start=frozen(starts, np.int64),
        coupling=frozen(joined["coupling"]),
        cross_damping_start=frozen(np.zeros(len(modes) + 1), np.int64),
        cross_damping=frozen([]),
        geometric_start=frozen(geometric_start, np.int64),
        geometric=frozen(np.concatenate(geometric)),
        axial_start=frozen(np.cumsum([0, *map(len, ends)]), np.int64),
        axial_mode=frozen(np.concatenate(ends), np.int64),
        bending_start=frozen(np.cumsum([0, *map(len, middles)]), np.int64),
        bending_mode=frozen(np.concatenate(middles), np.int64),
        shortening_start=frozen(np.cumsum([0, *map(len, matrices)]), np.int64),
        shortening=frozen(np.concatenate(matrices)),
    )


def no_loads(gravity: tuple[float, float]) -> Loads:
    return Loads(
        gravity=frozen(gravity),
        spring_kind=frozen([], np.int64),
        spring_point=frozen([], np.int64, columns=2),
        spring_axis=frozen([], columns=2),
        spring_value=frozen([], columns=3),
        force_kind=frozen([], np.int64),
        force_point=frozen([], np.int64),
        force_signal=frozen([], np.int64, columns=2),
    )


def kinetic_hessian(bodies: Bodies, q: FloatArray) -> FloatArray:
    """M(q) from the kinetic energy alone: T is quadratic in u."""
    n = len(q)
    work = arrow(len(bodies.mass), len(bodies.stiffness))
    loads = no_loads((0.0, 0.0))

    def kinetic(u: FloatArray) -> float:
        return stored_energies(bodies, loads, q, u, work)[0]

    unit = np.eye(n)
    single = np.array([kinetic(e) for e in unit])
    return np.array([[kinetic(a + b) - single[i] - single[j] for j, b in enumerate(unit)] for i, a in enumerate(unit)])


@pytest.mark.parametrize(("modes", "stiffened"), [((0,), ()), ((5,), (0,)), ((3, 0, 4), (2,))])
def test_arrow_solve_inverts_the_matrix(modes: tuple[int, ...], stiffened: tuple[int, ...]) -> None:
    bodies = random_bodies(modes, stiffened)
    q = 0.3 * RNG.normal(size=bodies.dof[-1])
    matrix = kinetic_hessian(bodies, q)
    alpha_c, alpha_k = 0.4, 0.7
    for b in range(len(modes)):
        modal = slice(bodies.dof[b] + 3, bodies.dof[b + 1])
        own = slice(bodies.dof[b] - 3 * b, bodies.dof[b + 1] - 3 * (b + 1))
        matrix[modal, modal] += np.diag(alpha_c * bodies.damping[own] + alpha_k * bodies.stiffness[own])
    work = arrow(len(modes), len(bodies.stiffness))
    factorise(bodies, q, alpha_c, alpha_k, work)
    right = RNG.normal(size=len(q))
    x = right.copy()
    for b in range(len(modes)):
        block = x[bodies.dof[b] : bodies.dof[b + 1]]
        solve_block(bodies, work, b, block, block)
    np.testing.assert_allclose(matrix @ x, right, rtol=0, atol=1e-11)


def elastic_hessian(bodies: Bodies, q: FloatArray) -> FloatArray:
    """Second derivatives of the elastic energy, by differences of the forces."""
    n, still, e = len(q), np.zeros(len(q)), 1e-5
    hessian = np.zeros((n, n))
    for i in range(n):
        for side in (1.0, -1.0):
            moved, force = q.copy(), np.zeros(n)
            moved[i] += side * e
            elastic_forces(bodies, moved, still, force, np.zeros(n))
            hessian[i] -= side * force / (2.0 * e)
    return hessian


def dense_work(bodies: Bodies) -> Arrow:
    modes = np.diff(bodies.dof) - 3
    return arrow(len(modes), len(bodies.stiffness), np.where(np.diff(bodies.shortening_start) > 0, modes, 0))


@pytest.mark.parametrize(("modes", "shortened"), [((5,), (0,)), ((4, 0, 5, 3), (0, 2))])
def test_solve_takes_the_whole_tangent_of_a_body_that_shortens(
    modes: tuple[int, ...], shortened: tuple[int, ...]
) -> None:
    """In tension, M + alpha_c C + alpha_k d2V/dq2 is positive definite, and it is inverted to rounding."""
    bodies = random_bodies(modes, (), shortened)
    q = 0.2 * RNG.normal(size=bodies.dof[-1])
    alpha_c, alpha_k = 0.4, 0.2
    matrix = kinetic_hessian(bodies, q) + alpha_k * elastic_hessian(bodies, q)
    for b in range(len(modes)):
        modal = np.arange(bodies.dof[b] + 3, bodies.dof[b + 1])
        matrix[modal, modal] += alpha_c * bodies.damping[modal - 3 * (b + 1)]
    assert np.linalg.eigvalsh(matrix)[0] > 0.0
    work = dense_work(bodies)
    factorise(bodies, q, alpha_c, alpha_k, work)
    assert work.full.tolist() == [int(b in shortened) for b in range(len(modes))]
    right = RNG.normal(size=len(q))
    x = right.copy()
    for b in range(len(modes)):
        block = x[bodies.dof[b] : bodies.dof[b + 1]]
        solve_block(bodies, work, b, block, block)
    np.testing.assert_allclose(matrix @ x, right, rtol=0, atol=1e-8)


def test_compression_that_leaves_the_tangent_indefinite_is_left_out_of_the_factor() -> None:
    bodies = random_bodies((5,), (), (0,))
    q = 0.2 * RNG.normal(size=8)
    q[[3, 7]] = -50.0, 50.0  # compression in some direction of the bending modes, whatever the G_a are
    work = dense_work(bodies)
    factorise(bodies, q, 0.0, 1.0, work)
    assert np.linalg.eigvalsh(kinetic_hessian(bodies, q) + elastic_hessian(bodies, q))[0] < 0.0
    assert work.full[0] == 1
    assert np.isfinite(work.rigid).all()
    assert np.isfinite(work.dense).all()


@pytest.mark.parametrize(("modes", "stiffened"), [((0,), ()), ((5,), (0,)), ((3, 0, 4), (2,))])
def test_product_with_the_mass_matrix(modes: tuple[int, ...], stiffened: tuple[int, ...]) -> None:
    bodies = random_bodies(modes, stiffened)
    q = 0.3 * RNG.normal(size=bodies.dof[-1])
    x = RNG.normal(size=len(q))
    work = arrow(len(modes), len(bodies.stiffness))
    factorise(bodies, q, 0.4, 0.7, work)
    out = np.full(len(q), np.nan)
    multiply(bodies, q, x, work, out)
    np.testing.assert_allclose(out, kinetic_hessian(bodies, q) @ x, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("modes", "stiffened", "shortened"),
    [
        ((0,), (), ()),
        ((5,), (), ()),
        ((2, 3), (), ()),
        ((5,), (0,), ()),
        ((2, 3), (0, 1), ()),
        ((5,), (), (0,)),
        ((4, 3, 5), (1,), (0, 2)),
    ],
)
def test_forces_are_those_of_the_lagrangian(
    modes: tuple[int, ...], stiffened: tuple[int, ...], shortened: tuple[int, ...]
) -> None:
    """h = dT/dq - (dM/dt) u - dV/dq, by central differences of the energies."""
    bodies = random_bodies(modes, stiffened, shortened)
    loads = no_loads((0.3, -9.81))
    q = 0.3 * RNG.normal(size=bodies.dof[-1])
    u = RNG.normal(size=len(q))
    work = arrow(len(modes), len(bodies.stiffness))
    e = 1e-5

    def lagrangian(q: FloatArray) -> float:
        kinetic, elastic, weight = stored_energies(bodies, loads, q, u, work)
        return kinetic - elastic - weight

    gradient = np.array([(lagrangian(q + e * i) - lagrangian(q - e * i)) / (2 * e) for i in np.eye(len(q))])
    change = (kinetic_hessian(bodies, q + e * u) - kinetic_hessian(bodies, q - e * u)) @ u / (2 * e)
    force, dissipative = np.zeros(len(q)), np.zeros(len(q))
    inertial_forces(bodies, loads, q, u, force)
    elastic_forces(bodies, q, u, force, dissipative)
    np.testing.assert_allclose(force, gradient - change, rtol=0, atol=1e-6 * np.abs(force).max())


@pytest.mark.parametrize(("modes", "shortened"), [((0, 0), ()), ((5, 0, 3), ()), ((4, 0, 5, 3), (0, 2))])
def test_products_of_white_rows_are_those_with_the_inverse(modes: tuple[int, ...], shortened: tuple[int, ...]) -> None:
    bodies = random_bodies(modes, (), shortened)
    q = 0.2 * RNG.normal(size=bodies.dof[-1])
    work = dense_work(bodies)
    factorise(bodies, q, 0.4, 0.2, work)
    row_body = RNG.integers(-1, len(modes), (12, 2))
    rows, white = np.zeros((12, 2, 3 + max(modes))), np.zeros((12, 2, 3 + max(modes)))
    for r, i in zip(*np.nonzero(row_body >= 0), strict=True):
        rows[r, i, : 3 + modes[row_body[r, i]]] = RNG.normal(size=3 + modes[row_body[r, i]])
    whiten_rows(bodies, work, rows, row_body, 0, 12, white)
    for (r, i), (s, j) in itertools.combinations_with_replacement(np.argwhere(row_body >= 0).tolist(), 2):
        b = row_body[r, i]
        if row_body[s, j] == b:
            solved = np.zeros(3 + modes[b])
            solve_block(bodies, work, b, rows[s, j, : len(solved)], solved)
            product = rows[r, i, : len(solved)] @ solved
            assert white[r, i] @ white[s, j] == pytest.approx(product, rel=1e-9, abs=1e-9)
