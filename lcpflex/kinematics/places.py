"""Where material points are in the world, r = R + A (x + Phi q), and how fast they move."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.arrays import Model
from lcpflex.model.layout import SPACE, dimension
from lcpflex.model.planar import N_RIGID

__all__ = [
    "deflection",
    "material_shapes",
    "modal_sum",
    "trajectory",
    "turned",
    "velocity",
    "velocity_rows",
    "world_places",
]


def turned(angle: FloatArray, s: FloatArray) -> FloatArray:
    """A(angle) s for angles (...) and vectors (..., 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * s[..., 0] - sin * s[..., 1], sin * s[..., 0] + cos * s[..., 1]], axis=-1)


def trajectory(model: Any, q: FloatArray, b: int, place: FloatArray, phi: FloatArray) -> FloatArray:
    """World place of material points of body b: q (..., nq), place (..., 2), phi (..., n, 2); in space 3 for 2."""
    if dimension(model.bodies) is SPACE:
        k = int(model.bodies.place[b])
        modal = slice(k + SPACE.places, k + SPACE.places + phi.shape[-2])
        return np.asarray(q[..., k : k + 3] + rotated(q[..., k + 3 : k + 7], place + modal_sum(q[..., modal], phi)))
    d = int(model.bodies.dof[b])
    s = place + modal_sum(q[..., d + N_RIGID : d + N_RIGID + phi.shape[-2]], phi)
    return q[..., d : d + 2] + turned(q[..., d + 2], s)


def deflection(model: Any, q: FloatArray, b: int, phi: FloatArray) -> FloatArray:
    """Phi q of material points of body b in its frame: q (..., nq), phi (..., n, 2); in space 3 for 2."""
    size, bodies = dimension(model.bodies), model.bodies
    first = int((bodies.place if size is SPACE else bodies.dof)[b]) + size.places
    return modal_sum(q[..., first : first + phi.shape[-2]], phi)


def velocity(model: Any, q: FloatArray, u: FloatArray, b: int, place: FloatArray, phi: FloatArray) -> FloatArray:
    """rdot = Rdot + A (Phi qdot + omega J s) of one material point of body b: q, u (m, ndof), phi (n, 2); (m, 2).

    In space v + A (Phi etadot + omega x s), omega in body axes: (m, 3).
    """
    d = int(model.bodies.dof[b])
    if dimension(model.bodies) is SPACE:
        k, n = int(model.bodies.place[b]), phi.shape[0]
        s = place + modal_sum(q[:, k + SPACE.places : k + SPACE.places + n], phi)
        rate = modal_sum(u[:, d + SPACE.rigid : d + SPACE.rigid + n], phi) + np.cross(u[:, d + 3 : d + 6], s)
        return np.asarray(u[:, d : d + 3] + rotated(q[:, k + 3 : k + 7], rate))
    modal = slice(d + N_RIGID, d + N_RIGID + phi.shape[0])
    s, spin = place + modal_sum(q[:, modal], phi), u[:, d + 2]
    rate = modal_sum(u[:, modal], phi) + np.column_stack([-spin * s[:, 1], spin * s[:, 0]])
    return np.asarray(u[:, d : d + 2] + turned(q[:, d + 2], rate))


def velocity_rows(model: Any, q: FloatArray, b: int, place: FloatArray, phi: FloatArray) -> FloatArray:
    """L (2, ndof) of :func:`velocity`, rdot = L u, at one configuration q (nq,); in space (3, ndof)."""
    size = dimension(model.bodies)
    n, d = phi.shape[0], int(model.bodies.dof[b])
    rates = np.zeros((size.rigid + n, int(model.bodies.dof[-1])))
    rates[np.arange(size.rigid + n), d + np.arange(size.rigid + n)] = 1.0
    return velocity(model, np.tile(q, (len(rates), 1)), rates, b, place, phi).T @ rates


def modal_sum(q: FloatArray, phi: FloatArray) -> FloatArray:
    """Sum of q_n phi_n, one mode after the other: q (..., n), phi (..., n, 2).

    So the bits of a place do not depend on how many instants it is asked for, as those of a matrix product do.
    """
    total = np.zeros(np.broadcast_shapes(q.shape[:-1], phi.shape[:-2]) + phi.shape[-1:])
    for n in range(phi.shape[-2]):
        total += q[..., n, None] * phi[..., n, :]
    return total


def material_shapes(model: Model, points: IntArray) -> FloatArray:
    """Mode shapes (k, n, 2) of k material points of one body; n = 0 on the ground and on rigid bodies."""
    start, phi = model.points.start, model.points.phi
    return np.stack([phi[start[p] : start[p + 1]] for p in points]) if len(points) else np.zeros((0, 0, phi.shape[1]))


def world_places(model: Model, q: FloatArray, points: IntArray) -> FloatArray:
    """r_P = R + A (x + Phi q) of k material points at the configuration q (nq,): (k, 2) or (k, 3) [m]."""
    places = np.empty((len(points), model.points.place.shape[1]))
    owners = model.points.body[points]
    for b in np.unique(owners):
        chosen = np.flatnonzero(owners == b)
        ids = points[chosen]
        x = model.points.place[ids]
        places[chosen] = x if b < 0 else trajectory(model, q[None, :], int(b), x, material_shapes(model, ids))
    return places
