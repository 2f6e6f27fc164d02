"""Modes without mass of spatial bodies: see :mod:`lcpflex.dynamics.static_modes`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from lcpflex.contact.spatial.kinds import FACET, PLANE, POLYGON
from lcpflex.dynamics.static_modes import RIGID, uncoupled
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.rotations import axes_at
from lcpflex.model.arrays import changed
from lcpflex.model.spatial import N_RIGID, SpatialBodies, SpatialModel

__all__ = ["at_rest", "directional", "frame_axes", "massless", "normal_of", "square_products", "with_products"]

FLAT = (FACET, PLANE, POLYGON)  # features with a normal of their own


def at_rest(model: SpatialModel) -> FloatArray:
    """q of all bodies as they were made: at the origin, unturned and undeformed."""
    q = np.zeros(int(model.bodies.place[-1]))
    q[model.bodies.place[:-1] + 3] = 1.0
    return q


def frame_axes(model: SpatialModel, q: FloatArray, b: int) -> FloatArray:
    """A of body b, columns being its axes in the world; of the ground, -1, those."""
    return axes_at(q, int(model.bodies.place[b])) if b >= 0 else np.eye(3)


def massless(bodies: SpatialBodies, static: list[npt.NDArray[np.bool_]]) -> SpatialBodies:
    """The bodies without the mass and damping of the modes ``static``, (n,) of each body."""
    flat = np.concatenate([*static, np.zeros(0, dtype=bool)])
    products = []
    for b, still in enumerate(static):
        P = square_products(bodies, b)
        P[still], P[:, still] = 0.0, 0.0
        products.append(P)
    bodies = with_products(bodies, products)
    stiffening = len(bodies.geometric) > 0
    return changed(
        SpatialBodies,
        bodies,
        S=np.where(flat[:, None], 0.0, bodies.S),
        first=np.where(flat[:, None], 0.0, bodies.first),
        damping=np.where(flat, 0.0, bodies.damping),
        cross_damping=uncoupled(bodies.cross_damping, bodies.cross_damping_start, static),
        geometric=uncoupled(bodies.geometric, bodies.geometric_start, static) if stiffening else bodies.geometric,
    )


def square_products(bodies: SpatialBodies, b: int) -> FloatArray:
    """(n, n, 9) <Phi_l Phi_k^T> of body b, 0 where they are not kept."""
    n, n2 = int(bodies.dof[b + 1] - bodies.dof[b]) - N_RIGID, int(bodies.second_modes[b])
    P = np.zeros((n, n, 9))
    start = int(bodies.products_start[b])
    P[:n2, :n2] = bodies.products[start : start + 9 * n2 * n2].reshape(n2, n2, 9)
    return P


def with_products(bodies: SpatialBodies, products: list[FloatArray]) -> SpatialBodies:
    """The bodies with ``products`` (n, n, 9) of each, as many of them as are not 0."""
    some = [np.flatnonzero(P.any(axis=(1, 2)) | P.any(axis=(0, 2))) for P in products]
    count = [int(where[-1]) + 1 if len(where) else 0 for where in some]
    flat = [P[:n2, :n2].ravel() for P, n2 in zip(products, count, strict=True)]
    return changed(
        SpatialBodies,
        bodies,
        second_modes=np.array(count, dtype=np.int64),
        products_start=np.cumsum([0, *(len(part) for part in flat)]),
        products=np.concatenate([np.zeros(0), *flat]),
    )


def directional(model: SpatialModel, q: FloatArray, f: int, F: FloatArray) -> tuple[bool, bool]:
    """Whether F (3, 3) gives way along the normal and both tangents of a feature; of round ones, along any."""
    values = np.linalg.eigvalsh(F)
    if not values[2] > 0.0:
        return False, False
    kind = int(model.contacts.feature_kind[f])
    if kind not in FLAT:
        return True, bool(values[1] > RIGID * values[2])
    n = normal_of(model, f, frame_axes(model, q, int(model.points.body[model.contacts.feature_point[f, 0]])))
    across = np.linalg.svd(n[None])[2][1:]
    least = np.linalg.eigvalsh(across @ F @ across.T)[0]
    return bool(n @ F @ n > RIGID * values[2]), bool(least > RIGID * values[2])


def normal_of(model: SpatialModel, f: int, A: FloatArray) -> FloatArray:
    """Unit normal of flat feature f, undeformed, in axes in which those of its body are the columns of A."""
    a, b, c = model.points.place[model.contacts.feature_point[f]]
    n = np.cross(b - a, c - a)
    return np.asarray(A @ (n / np.linalg.norm(n)))
