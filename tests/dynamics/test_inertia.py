"""The arrow inertia against dense linear algebra, and its forces against the Lagrangian they come from."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.compiled import FloatArray
from lcpflex.dynamics.inertia import (
    arrow,
    elastic_forces,
    factorise,
    inertial_forces,
    multiply,
    solve_block,
    stored_energies,
)
from lcpflex.model import Bodies, Loads, frozen

RNG = np.random.default_rng(7)


def random_bodies(modes: tuple[int, ...], stiffened: tuple[int, ...] = ()) -> Bodies:
    """Bodies whose integrals come from point masses, so that every matrix is a possible one; some of them stiffened."""
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
    )


def no_loads(gravity: tuple[float, float]) -> Loads:
    return Loads(
        gravity=frozen(gravity),
        spring_kind=frozen([], np.int64),
        spring_point=frozen([], np.int64, columns=2),
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


@pytest.mark.parametrize(("modes", "stiffened"), [((0,), ()), ((5,), ()), ((2, 3), ()), ((5,), (0,)), ((2, 3), (0, 1))])
def test_forces_are_those_of_the_lagrangian(modes: tuple[int, ...], stiffened: tuple[int, ...]) -> None:
    """h = dT/dq - (dM/dt) u - dV/dq, by central differences of the energies."""
    bodies = random_bodies(modes, stiffened)
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
