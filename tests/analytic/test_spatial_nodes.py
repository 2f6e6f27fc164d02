"""Inertial forces of spatial bodies against their nodes: places in time differentiated, with the consistent mass.

Neither energy nor momenta of a free flight tell a wrong Coriolis force between modes, which has no power: only this
check does, and it is shown to.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from lcpflex.dynamics import mechanics as leaves
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.spatial.body_forces import turn_modes
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.rotations import compose, exponential, rotation_matrix
from tests import libs
from tests.spatial_bodies import MassBody, in_mean_frame, mechanics, orthonormal, spatial_model

FIRST = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
SECOND = {1: 8 / 5, 2: -1 / 5, 3: 8 / 315, 4: -1 / 560}
CENTRE = -205 / 72
STEP = 0.02
KINDS = [
    ("hexahedra", "free"),
    ("hexahedra", "clamped"),
    ("quadratic hexahedra", "free"),
    ("quadratic hexahedra", "clamped"),
    ("tetrahedra", "free"),
    ("quadratic tetrahedra", "free"),
    ("quadratic tetrahedra", "clamped"),
]
ELEMENTS = {
    "hexahedra": "ElementHex1",
    "quadratic hexahedra": "ElementHex2",
    "tetrahedra": "ElementTetP1",
    "quadratic tetrahedra": "ElementTetP2",
}


@cache
def solid(kind: str, frame: str, n: int = 6) -> MassBody:
    """A block of 1 x 0.6 x 0.4 with a corner cut off its lines of symmetry by a shear; E = 20, nu = 0.3, rho = 1.7."""
    skfem, h = libs.skfem, libs.skfem_helpers
    sides = [np.linspace(0, length, count) for length, count in ((1.0, 4), (0.6, 3), (0.4, 2))]
    mesh: Any = (skfem.MeshHex if "hexa" in kind else skfem.MeshTet).init_tensor(*sides)
    places = mesh.p.copy()
    places[1] += 0.2 * places[0] + 0.1 * places[0] * places[2]
    mesh = type(mesh)(places, mesh.t)
    element = getattr(skfem, ELEMENTS[kind])()
    basis: Any = skfem.Basis(mesh, element, intorder=5)
    vector: Any = skfem.Basis(mesh, skfem.ElementVector(element), intorder=5)
    mass = 1.7 * skfem.BilinearForm(lambda u, v, _: u * v).assemble(basis).toarray()
    mu, lam = 20.0 / 2.6, 20.0 * 0.3 / (1.3 * 0.4)

    def energy(u: Any, v: Any, _: Any) -> Any:
        e, f = h.sym_grad(u), h.sym_grad(v)
        return h.ddot(2.0 * mu * e + lam * h.eye(h.trace(e), 3), f)

    K = skfem.BilinearForm(energy).assemble(vector).toarray()
    M = 1.7 * skfem.BilinearForm(lambda u, v, _: h.dot(u, v)).assemble(vector).toarray()
    nodes = basis.doflocs.T
    order = np.array([_components(vector, x) for x in nodes])
    assert np.abs(M[np.ix_(order[:, 0], order[:, 0])] - mass).max() < 1e-15
    K = K[np.ix_(order.ravel(), order.ravel())]
    M = np.kron(mass, np.eye(3))
    if frame == "free":
        nodes = nodes - mass.sum(axis=0) @ nodes / mass.sum()
        _, modes = scipy.linalg.eigh(K, M, subset_by_index=(6, 5 + n))
        shapes = in_mean_frame(mass, modes.T.reshape(n, -1, 3), nodes)
    else:
        free = np.repeat(nodes[:, 0] > 1e-9, 3)
        modes = np.zeros((len(K), n))
        _, modes[free] = scipy.linalg.eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], subset_by_index=(0, n - 1))
        shapes = orthonormal(mass, modes.T.reshape(n, -1, 3))
    return MassBody(mass, nodes, shapes, centred=frame == "free", stiffness=np.ones(n), damping=np.zeros(n))


def _components(vector: Any, x: FloatArray) -> FloatArray:
    """The three numbers of the vector field at a node."""
    found: FloatArray = np.flatnonzero(np.abs(vector.doflocs.T - x).max(axis=1) < 1e-9)
    assert len(found) == 3
    return found


class Motion:
    """A body that passes a state with an acceleration."""

    def __init__(self, body: MassBody) -> None:
        rng = np.random.default_rng(4)
        self.body = body
        self.q = np.concatenate([rng.normal(size=3), rng.normal(size=4), 0.2 * rng.normal(size=body.n)])
        self.q[3:7] /= np.linalg.norm(self.q[3:7])
        self.u, self.udot = rng.normal(size=(2, 6 + body.n))
        self.model = spatial_model([body])
        made = mechanics(self.model, self.q, self.u)
        self.packed, self.work = made.model, made.work

    def places(self, step: FloatArray) -> FloatArray:
        """Of the nodes, where q is moved by a vector (6 + n,)."""
        q = self.q
        turn = compose(tuple(q[3:7]), exponential(*step[3:6]))
        s = self.body.places + np.einsum("k,kni->ni", q[7:] + step[6:], self.body.shapes)
        return np.asarray(q[:3] + step[:3] + s @ np.reshape(rotation_matrix(*turn), (3, 3)).T)

    def directions(self) -> FloatArray:
        """L^T (6 + n, N, 3): velocities of the nodes of unit velocities."""
        units = np.eye(len(self.u))
        return (
            np.array(
                [
                    sum(w * (self.places(j * STEP * e) - self.places(-j * STEP * e)) for j, w in FIRST.items())
                    for e in units
                ]
            )
            / STEP
        )

    def accelerations(self) -> FloatArray:
        """Of the nodes; along R + v t + .., p o exp(omega t + omegadot t^2 / 2), eta + .., which has udot at t = 0."""
        total = CENTRE * self.places(0.0 * self.u)
        for j, w in SECOND.items():
            for t in (j * STEP, -j * STEP):
                total += w * self.places(t * self.u + 0.5 * t * t * self.udot)
        return np.asarray(total / STEP**2)

    def by_nodes(self) -> FloatArray:
        """Generalised inertial forces, M udot - h."""
        loads = np.einsum("mn,ni->mi", self.body.mass, self.accelerations())
        return np.einsum("ami,mi->a", self.directions(), loads)

    def by_kernels(self) -> tuple[FloatArray, FloatArray]:
        """The same, and h."""
        leaves.forces(self.packed, 0.0, self.q, self.u, self.work)
        leaves.factorise(self.packed, self.q, 0.0, 0.0, self.work)
        out = np.zeros(len(self.u))
        leaves.multiply(self.packed, self.q, self.udot, self.work, out)
        h = self.work.rows.arrow.spin.copy()
        return out - h, h

    def coriolis(self) -> FloatArray:
        """The term of h between modes alone."""
        out = np.zeros(len(self.u))
        turn_modes(self.packed.bodies, self.u, 0, self.work.rows.arrow, out)
        return out


@pytest.mark.parametrize(("kind", "frame"), KINDS)
def test_forces_are_those_of_the_nodes(kind: str, frame: str) -> None:
    motion = Motion(solid(kind, frame))
    expected = motion.by_nodes()
    found, _ = motion.by_kernels()
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()
    M = mass_matrix(motion.model, motion.q)  # type: ignore[arg-type]
    L = motion.directions()
    own = np.einsum("ami,mn,bni->ab", L, motion.body.mass, L, optimize=True)
    assert np.abs(M - own).max() < 1e-10 * np.abs(own).max()


@pytest.mark.parametrize(("kind", "frame"), [("hexahedra", "free"), ("quadratic tetrahedra", "clamped")])
def test_nodes_alone_tell_a_wrong_coriolis_force(kind: str, frame: str) -> None:
    motion = Motion(solid(kind, frame))
    expected = motion.by_nodes()
    found, h = motion.by_kernels()
    term = motion.coriolis()
    without, reversed_sign = found + term, found + 2.0 * term
    assert np.abs(term[6:]).max() > 0.01 * np.abs(h).max()
    assert np.abs(without - expected).max() > 1e-3 * np.abs(expected).max()
    assert np.abs(reversed_sign - expected).max() > 2e-3 * np.abs(expected).max()
    assert abs(term @ motion.u) < 1e-14  # no power
    assert not term[:6].any()  # nor momentum
