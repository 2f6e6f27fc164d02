"""Bodies whose points and modes lie in one plane: the kernels of space are there those of the plane."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from lcpflex.dynamics import body_forces as planar
from lcpflex.dynamics.inertia import arrow
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.spatial import body_forces as spatial
from lcpflex.dynamics.spatial.inertia import factors
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Bodies, Loads, Model, empty, frozen
from lcpflex.model.spatial import SpatialBodies, SpatialModel
from tests.spatial_bodies import MassBody, in_mean_frame, orthonormal, spatial_model

GRAVITY = (1.3, -9.81)
MODES = (4, 0, 3)


def flat_bodies(rng: np.random.Generator) -> list[MassBody]:
    """Point masses in z = 0 that move there; the last body in a mean frame."""
    found = []
    for n in MODES:
        mass = np.diag(rng.uniform(0.5, 1.5, 20))
        places, shapes = rng.normal(size=(20, 3)), rng.normal(size=(n, 20, 3))
        places[:, 2], shapes[:, :, 2] = 0.0, 0.0
        centred = n == MODES[-1]
        if centred:
            places = places - mass.sum(axis=0) @ places / mass.sum()
            shapes = in_mean_frame(mass, shapes, places)
        elif n:
            shapes = orthonormal(mass, shapes)
        found.append(
            MassBody(mass, places, shapes, centred, stiffness=rng.uniform(1, 9, n), damping=rng.uniform(0, 0.2, n))
        )
    return found


def planar_model(bodies: list[MassBody], space: SpatialModel, stiffened: list[FloatArray]) -> Model:
    """Their planar arrays, from the definitions in ``Bodies``; stiffened: G (n, n) of each."""
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    fields = [(b.mass.sum(axis=0), b.places[:, :2], b.shapes[:, :, :2]) for b in bodies]
    coupling = [np.einsum("p,kpi,ij,lpj->kl", w, phi, quarter.T, phi).ravel() for w, _, phi in fields]
    nowhere = frozen(np.zeros(len(bodies) + 1), np.int64)
    starts = ("cross_damping_start", "axial_start", "bending_start", "shortening_start")
    made = empty(
        Bodies,
        dof=frozen(np.cumsum([0, *(3 + b.n for b in bodies)]), np.int64),
        mass=frozen([w.sum() for w, _, _ in fields]),
        inertia=frozen([w @ (x**2).sum(axis=1) for w, x, _ in fields]),
        moment=frozen([w @ x for w, x, _ in fields]),
        S=frozen(np.concatenate([np.einsum("p,kpi->ki", w, phi) for w, _, phi in fields])),
        a=frozen(np.concatenate([np.einsum("p,kpi,pi->k", w, phi, x) for w, x, phi in fields])),
        c=frozen(np.concatenate([np.einsum("p,kpi,ij,pj->k", w, phi, quarter, x) for w, x, phi in fields])),
        stiffness=space.bodies.stiffness,
        damping=space.bodies.damping,
        coupling_start=frozen(np.cumsum([0, *map(len, coupling)]), np.int64),
        coupling=frozen(np.concatenate(coupling)),
        geometric_start=frozen(np.cumsum([0, *(G.size for G in stiffened)]), np.int64),
        geometric=frozen(np.concatenate([G.ravel() for G in stiffened])),
        **dict.fromkeys(starts, nowhere),
    )
    return Model(made, *(None,) * 3, empty(Loads, gravity=frozen(GRAVITY)), None)  # type: ignore[arg-type]


def stiffened_about_z(bodies: SpatialBodies, stiffened: list[FloatArray]) -> SpatialBodies:
    """The bodies with G_zz, and what tells of spin about other axes alone: G_yz and G_zx would turn them out of it."""
    flat = [np.stack([3.0 * G, 2.0 * G, G, 0.0 * G, 0.0 * G, G], axis=2).ravel() for G in stiffened]
    start = frozen(np.cumsum([0, *map(len, flat)]), np.int64)
    return bodies._replace(geometric_start=start, geometric=frozen(np.concatenate(flat)))


class Twins:
    """A state in the plane, and the same in space."""

    def __init__(self) -> None:
        rng = np.random.default_rng(6)
        bodies = flat_bodies(rng)
        G = [0.1 * (one + one.T) for one in (np.random.default_rng(n).normal(size=(n, n)) for n in MODES)]
        plain = spatial_model(bodies, (*GRAVITY, 0.0))
        self.space = plain._replace(bodies=stiffened_about_z(plain.bodies, G))
        self.plane = planar_model(bodies, self.space, G)
        self.q, self.u = 0.4 * rng.normal(size=(2, self.plane.bodies.dof[-1]))
        self.spatial_q, self.spatial_u = np.zeros(self.space.bodies.place[-1]), np.zeros(self.space.bodies.dof[-1])
        self.same = np.zeros(len(self.u), dtype=np.int64)  # entries of u in space that are those of the plane
        places, dofs = self.space.bodies.place.tolist(), self.space.bodies.dof.tolist()
        for b, (d, end) in enumerate(itertools.pairwise(self.plane.bodies.dof.tolist())):
            i, e = places[b], dofs[b]
            self.spatial_q[i : i + 2] = self.q[d : d + 2]
            self.spatial_q[[i + 3, i + 6]] = np.cos(0.5 * self.q[d + 2]), np.sin(0.5 * self.q[d + 2])
            self.spatial_q[i + 7 : places[b + 1]] = self.q[d + 3 : end]
            self.same[d:end] = [e, e + 1, e + 5, *range(e + 6, dofs[b + 1])]
        self.spatial_u[self.same] = self.u
        self.other = np.setdiff1d(np.arange(len(self.spatial_u)), self.same)

    def agree(self, of_space: FloatArray, of_plane: FloatArray) -> None:
        np.testing.assert_allclose(of_space[self.same], of_plane, rtol=0, atol=2e-13)
        np.testing.assert_allclose(of_space[self.other], 0.0, rtol=0, atol=2e-13)


@pytest.fixture(scope="module")
def twins() -> Twins:
    return Twins()


def test_mass_matrices_agree(twins: Twins) -> None:
    of_plane = mass_matrix(twins.plane, twins.q)
    of_space = mass_matrix(twins.space, twins.spatial_q)  # type: ignore[arg-type]
    np.testing.assert_allclose(of_space[np.ix_(twins.same, twins.same)], of_plane, rtol=0, atol=1e-13)
    assert np.abs(of_space[np.ix_(twins.same, twins.other)]).max() < 1e-13


def test_forces_agree(twins: Twins) -> None:
    """Centrifugal, Coriolis, weight, stiffness and damping."""
    work = factors(twins.space.bodies)
    flat, in_space, weight = np.zeros(len(twins.u)), np.zeros(len(twins.spatial_u)), np.zeros(len(twins.spatial_u))
    planar.inertial_forces(twins.plane.bodies, twins.plane.loads, twins.q, twins.u, flat)
    spatial.inertial_forces(twins.space.bodies, twins.spatial_q, twins.spatial_u, work, in_space)
    spatial.weight_forces(twins.space.bodies, twins.space.loads, twins.spatial_q, work, weight)
    twins.agree(in_space + weight, flat)
    assert np.abs(in_space).max() > 1.0
    kept, lost, spatial_kept, spatial_lost = (np.zeros(len(u)) for u in (flat, flat, in_space, in_space))
    planar.elastic_forces(twins.plane.bodies, twins.q, twins.u, kept, lost)
    spatial.elastic_forces(twins.space.bodies, twins.spatial_q, twins.spatial_u, spatial_kept, spatial_lost)
    twins.agree(spatial_kept, kept)
    twins.agree(spatial_lost, lost)


def test_energies_agree(twins: Twins) -> None:
    memory = arrow(len(MODES), sum(MODES))
    of_plane = planar.stored_energies(twins.plane.bodies, twins.plane.loads, twins.q, twins.u, memory)
    work = factors(twins.space.bodies)
    of_space = spatial.stored_energies(twins.space.bodies, twins.space.loads, twins.spatial_q, twins.spatial_u, work)
    assert of_space == pytest.approx(of_plane, rel=1e-13)
