"""Spatial bodies of point masses, for tests of the kernels: every integral is a sum, and places of points are exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Signals, empty, frozen
from lcpflex.model.spatial import (
    SpatialBodies,
    SpatialJoints,
    SpatialLoads,
    SpatialModel,
    SpatialPointTable,
    no_spatial_contacts,
)
from lcpflex.steppers.system import System


@dataclass
class MassBody:
    """A body with a mass matrix between nodes: (N, N), scalar; places (N, 3) and mode shapes (n, N, 3)."""

    mass: FloatArray
    places: FloatArray
    shapes: FloatArray
    centred: bool = False
    second_modes: int | None = None
    stiffness: FloatArray | None = None
    damping: FloatArray | None = None

    @property
    def n(self) -> int:
        return len(self.shapes)


def rigid_motions(places: FloatArray) -> FloatArray:
    """(6, N, 3): three translations and three rotations of nodes."""
    shifts = np.broadcast_to(np.eye(3)[:, None, :], (3, *places.shape))
    turns = np.stack([np.cross(np.broadcast_to(axis, places.shape), places) for axis in np.eye(3)])
    return np.concatenate([shifts, turns])


def inner(mass: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """(A, B) products of fields (A, N, 3) and (B, N, 3) with the mass matrix."""
    return np.einsum("ami,mn,bni->ab", a, mass, b, optimize=True)


def orthonormal(mass: FloatArray, shapes: FloatArray) -> FloatArray:
    """The same space of fields, M_ff = I."""
    return np.einsum(
        "ak,ami->kmi", np.linalg.inv(np.linalg.cholesky(inner(mass, shapes, shapes))).T, shapes, optimize=True
    )


def in_mean_frame(mass: FloatArray, shapes: FloatArray, places: FloatArray) -> FloatArray:
    """Fields without linear and angular momentum, orthonormal."""
    rigid = rigid_motions(places)
    share = np.linalg.solve(inner(mass, rigid, rigid), inner(mass, rigid, shapes))
    return orthonormal(mass, shapes - np.einsum("rk,rmi->kmi", share, rigid))


def random_body(
    rng: np.random.Generator, n: int, centred: bool = False, points: int = 30, second_modes: int | None = None
) -> MassBody:
    """Point masses, anywhere."""
    mass = np.diag(rng.uniform(0.5, 1.5, points)) / points
    places = rng.normal(size=(points, 3)) * np.array([1.0, 0.7, 0.4]) + np.array([0.3, -0.2, 0.1])
    shapes = rng.normal(size=(n, points, 3))
    if centred:
        places = places - mass.sum(axis=0) @ places / mass.sum()
        shapes = in_mean_frame(mass, shapes, places) if n else shapes
    elif n:
        shapes = orthonormal(mass, shapes)
    return MassBody(mass, places, shapes, centred, second_modes, rng.uniform(1.0, 9.0, n), rng.uniform(0.0, 0.2, n))


def spatial_bodies(bodies: list[MassBody]) -> SpatialBodies:
    """Their integrals: products of nodal values with the mass matrix, nothing lumped."""
    modes = [body.n for body in bodies]
    second = [body.n if body.second_modes is None else body.second_modes for body in bodies]
    products = [
        np.einsum("lmi,mn,knj->lkij", body.shapes[:n], body.mass, body.shapes[:n], optimize=True).ravel()
        for body, n in zip(bodies, second, strict=True)
    ]

    def joined(columns: int, parts: list[FloatArray]) -> FloatArray:
        return frozen(np.concatenate([part.reshape(-1, columns) for part in parts]))

    def flat(name: str) -> FloatArray:
        given = [getattr(body, name) for body in bodies]
        return frozen(np.concatenate([np.zeros(b.n) if g is None else g for b, g in zip(bodies, given, strict=True)]))

    weights = [body.mass.sum(axis=0) for body in bodies]
    pairs = list(zip(bodies, weights, strict=True))
    return SpatialBodies(
        dof=frozen(np.cumsum([0, *(6 + n for n in modes)]), np.int64),
        place=frozen(np.cumsum([0, *(7 + n for n in modes)]), np.int64),
        centred=frozen([int(body.centred) for body in bodies], np.int64),
        mass=frozen([w.sum() for w in weights]),
        moment=frozen([0.0 * w[:3] if body.centred else w @ body.places for body, w in pairs]),
        second=frozen([body.places.T @ body.mass @ body.places for body in bodies]),
        S=joined(3, [np.einsum("n,kni->ki", w, (not body.centred) * body.shapes) for body, w in pairs]),
        first=joined(9, [np.einsum("mi,mn,knj->kij", b.places, b.mass, b.shapes, optimize=True) for b in bodies]),
        stiffness=flat("stiffness"),
        damping=flat("damping"),
        cross_damping_start=frozen(np.zeros(len(bodies) + 1), np.int64),
        cross_damping=frozen([]),
        second_modes=frozen(second, np.int64),
        products_start=frozen(np.cumsum([0, *map(len, products)]), np.int64),
        products=frozen(np.concatenate(products)),
    )


def spatial_model(bodies: list[MassBody], gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> SpatialModel:
    """A scene of these bodies, without joints, springs, forces and contacts."""
    whole, real = np.int64, np.float64
    return SpatialModel(
        bodies=spatial_bodies(bodies),
        points=SpatialPointTable().compile(),
        signals=empty(Signals),
        joints=SpatialJoints(
            point=frozen(np.zeros((0, 2)), whole),
            row=frozen([0], whole),
            kind=frozen([], whole),
            axis=frozen(np.zeros((0, 3))),
            on_p=frozen(np.zeros((0, 3))),
            on_q=frozen(np.zeros((0, 3))),
            rest=frozen([], real),
            signal=frozen([], whole),
        ),
        loads=SpatialLoads(
            gravity=frozen(gravity),
            spring_kind=frozen([], whole),
            spring_point=frozen(np.zeros((0, 2)), whole),
            spring_axis=frozen(np.zeros((0, 3))),
            spring_on_p=frozen(np.zeros((0, 3))),
            spring_on_q=frozen(np.zeros((0, 3))),
            spring_value=frozen(np.zeros((0, 3))),
            force_kind=frozen([], whole),
            force_point=frozen([], whole),
            force_signal=frozen(np.zeros((0, 3)), whole),
        ),
        contacts=no_spatial_contacts(),
    )


def any_state(rng: np.random.Generator, model: SpatialModel, size: float = 0.3) -> tuple[FloatArray, FloatArray]:
    """q and u: anywhere, turned anyhow, deformed by about ``size``, all of it moving."""
    bodies = model.bodies
    q, u = size * rng.normal(size=bodies.place[-1]), rng.normal(size=bodies.dof[-1])
    for i in bodies.place[:-1]:
        q[i + 3 : i + 7] = rng.normal(size=4)
        q[i + 3 : i + 7] /= np.linalg.norm(q[i + 3 : i + 7])
    return q, u


@dataclass
class Mechanics:
    """A packed model and the memory of a stepper."""

    model: Any
    work: Any


def mechanics(model: SpatialModel, q: FloatArray, u: FloatArray) -> Mechanics:
    """What kernels take."""
    system = System(model=model, q=q, u=u, n_external=0, hooks={}, dense=False, margin=0.0)
    return Mechanics(pack(system.model), system.workspace(1))


def as_body(body: MassBody) -> SpatialBody:
    """The same as a body for scenes."""
    made = spatial_bodies([body])
    n2 = int(made.second_modes[0])
    return SpatialBody(
        mass=float(made.mass[0]),
        second=made.second[0],
        moment=made.moment[0],
        stiffness=made.stiffness,
        damping=made.damping,
        S=made.S,
        first=made.first,
        products=made.products.reshape(n2, n2, 9),
    )
