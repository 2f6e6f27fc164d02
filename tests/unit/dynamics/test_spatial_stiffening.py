"""Kernels of spatial bodies that spin stiffens, against their kinetic energy by numpy, differentiated numerically."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from lcpflex.dynamics import mechanics as leaves
from lcpflex.dynamics.mass_matrix import mass_matrix, overbent
from lcpflex.dynamics.spatial.body_forces import momenta
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.rotations import axes_at, compose, exponential
from lcpflex.model.arrays import frozen
from tests.spatial_bodies import MassBody, any_state, mechanics, random_body, spatial_model

WEIGHTS = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}  # of differences of eighth order
STEP = 5e-3
SIX = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))


def derivative(of: Callable[[float], Any]) -> Any:
    return sum(w * (of(j * STEP) - of(-j * STEP)) for j, w in WEIGHTS.items()) / STEP


class Stiffened:
    """Bodies of which all but the second have random matrices G, at a state."""

    def __init__(self) -> None:
        rng = np.random.default_rng(7)
        self.bodies = [random_body(rng, 5), random_body(rng, 4), random_body(rng, 6, centred=True), random_body(rng, 0)]
        self.bodies.append(random_body(rng, 7, second_modes=3))
        self.G = [self._matrices(rng, b, body) for b, body in enumerate(self.bodies)]
        plain = spatial_model(self.bodies)
        flat = [np.moveaxis(G, 0, 2).ravel() for G in self.G]
        self.linear = plain
        self.plain: Any = plain._replace(
            bodies=plain.bodies._replace(
                geometric_start=frozen(np.cumsum([0, *map(len, flat)]), np.int64),
                geometric=frozen(np.concatenate(flat)),
            )
        )
        self.q, self.u = any_state(rng, self.plain, size=0.2)
        made = mechanics(self.plain, self.q, self.u)
        self.model, self.work = made.model, made.work

    def _matrices(self, rng: np.random.Generator, b: int, body: MassBody) -> FloatArray:
        if b == 1 or not body.n:
            return np.zeros((6, 0, 0))
        G = rng.normal(size=(6, body.n, body.n))
        return np.asarray(0.1 * (G + G.transpose(0, 2, 1)))

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """That of linear motion, less eta^T G eta."""
        M = mass_matrix(self.linear, q)  # type: ignore[arg-type]
        for b, G in enumerate(self.G):
            if G.size:
                d, i = int(self.plain.bodies.dof[b]), int(self.plain.bodies.place[b])
                eta = q[i + 7 : i + 7 + self.bodies[b].n]
                for (j, k), one in zip(SIX, G, strict=True):
                    for entry in {(j, k), (k, j)}:
                        M[d + 3 + entry[0], d + 3 + entry[1]] -= eta @ one @ eta
        return M

    def moved(self, step: FloatArray) -> FloatArray:
        out = self.q.copy()
        for b in range(len(self.bodies)):
            d, i, n = int(self.plain.bodies.dof[b]), int(self.plain.bodies.place[b]), self.bodies[b].n
            out[i : i + 3] += step[d : d + 3]
            out[i + 3 : i + 7] = compose(tuple(out[i + 3 : i + 7]), exponential(*step[d + 3 : d + 6]))
            out[i + 7 : i + 7 + n] += step[d + 6 : d + 6 + n]
        return out


@pytest.fixture(scope="module")
def case() -> Stiffened:
    return Stiffened()


def test_mass_matrices_are_those_of_the_kinetic_energy(case: Stiffened) -> None:
    M = case.mass_matrix(case.q)
    np.testing.assert_allclose(mass_matrix(case.plain, case.q), M, rtol=0, atol=1e-14)
    assert np.abs(M - mass_matrix(case.linear, case.q)).max() > 0.01  # type: ignore[arg-type]
    out, x = np.zeros(len(case.u)), np.linspace(-1.0, 1.0, len(case.u))
    leaves.factorise(case.model, case.q, 0.0, 0.0, case.work)
    leaves.multiply(case.model, case.q, x, case.work, out)
    np.testing.assert_allclose(out, M @ x, rtol=0, atol=1e-13)
    leaves.solve_vector(case.model, case.work, out)
    np.testing.assert_allclose(out, x, rtol=0, atol=1e-12)


def test_forces_are_derivatives_of_the_kinetic_energy(case: Stiffened) -> None:
    """Lagrange's equations, in body axes of rotations: dp/dt + omega x p = dT/dq."""
    q, u = case.q, case.u
    leaves.forces(case.model, 0.0, q, u, case.work)
    units = np.eye(len(u))
    slope = np.array([derivative(lambda t, e=one: 0.5 * u @ case.mass_matrix(case.moved(t * e)) @ u) for one in units])
    expected = slope - derivative(lambda t: case.mass_matrix(case.moved(t * u)) @ u)
    p = case.mass_matrix(q) @ u
    for d in case.plain.bodies.dof[:-1]:
        expected[d + 3 : d + 6] -= np.cross(u[d + 3 : d + 6], p[d + 3 : d + 6])
    found = case.work.rows.arrow.spin.copy()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    still = mechanics(case.linear, q, u)
    leaves.forces(still.model, 0.0, q, u, still.work)
    others = slice(int(case.plain.bodies.dof[1]), int(case.plain.bodies.dof[2]))  # has no G: the same to the bit
    np.testing.assert_array_equal(found[others], still.work.rows.arrow.spin[others])
    assert np.abs(found - still.work.rows.arrow.spin).max() > 0.01


def test_energy_and_angular_momentum_know_it(case: Stiffened) -> None:
    M, u = case.mass_matrix(case.q), case.u
    kinetic, _, _ = leaves.energies(case.model, case.q, u, case.work)
    assert kinetic == pytest.approx(0.5 * u @ M @ u, rel=1e-13)
    out = np.zeros((len(case.bodies), 9))
    momenta(case.model.bodies, case.q, u, case.work.rows.arrow, out)
    for b, d in enumerate(case.plain.bodies.dof[:-1]):
        i, p = int(case.plain.bodies.place[b]), M @ u
        spin = axes_at(case.q, i) @ p[d + 3 : d + 6] + np.cross(case.q[i : i + 3], p[d : d + 3])
        np.testing.assert_allclose(out[b, 3:6], spin, rtol=0, atol=1e-12)


def test_what_is_bent_too_far_is_found(case: Stiffened) -> None:
    assert overbent(case.plain, case.q) == []
    i, q = int(case.plain.bodies.place[2]), case.q.copy()
    q[case.plain.bodies.place[4] + 7 :] = 0.0
    sizes, vectors = np.linalg.eigh(case.G[2][0])
    q[i + 7 : i + 13] = 3.0 * vectors[:, -1]
    assert overbent(case.plain, q) == []
    much = case.plain._replace(bodies=case.plain.bodies._replace(geometric=30.0 * case.plain.bodies.geometric))
    assert 30.0 * sizes[-1] > 2.0
    assert overbent(much, q) == [2]
