"""The mass matrix of a scene in full, for what happens once in a run. Steppers use its arrow form (inertia).

Bodies of space have theirs in :mod:`lcpflex.dynamics.spatial.mass_matrix`.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from lcpflex.dynamics.shortening import add_tangent, shortens
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Bodies, Model
from lcpflex.model.planar import N_RIGID

__all__ = [
    "body_mass_matrix",
    "elastic_matrices",
    "held_inverse",
    "mass_matrix",
    "null_space",
    "overbent",
    "slowest_vibrations",
]


def mass_matrix(model: Model, q: FloatArray) -> FloatArray:
    """M(q) (ndof, ndof), symmetric positive definite, block-diagonal over the bodies; T = u^T M u / 2 [J].

    M_RR = m I,  M_Rtheta = A J (s0 + S q),  M_Rf = A S,  M_thetatheta = I0 + 2 a.q + q.q - q^T G q,
    M_thetaf = c + D^T q,  M_ff = I
    """
    if space := _of_space(model.bodies):
        return np.asarray(space.mass_matrix(model, q))
    dof = model.bodies.dof
    M = np.zeros((dof[-1], dof[-1]))
    for b in range(len(dof) - 1):
        block = slice(dof[b], dof[b + 1])
        M[block, block] = body_mass_matrix(model.bodies, b, q[block])
    return M


def elastic_matrices(model: Model, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """K and C (ndof, ndof) of all bodies: second derivatives of their elastic energy at q, and their damping.

    The energy is that of :mod:`lcpflex.dynamics.body_forces`, q^T K q / 2 where no axial force acts on bending.
    """
    bodies = model.bodies
    if space := _of_space(bodies):
        stiffness, damping = space.elastic_matrices(bodies)
        return stiffness, damping
    n = int(bodies.dof[-1])
    K, C = np.zeros((n, n)), np.zeros((n, n))
    for b in range(len(bodies.dof) - 1):
        block = slice(int(bodies.dof[b]) + N_RIGID, int(bodies.dof[b + 1]))
        own = slice(block.start - N_RIGID * (b + 1), block.stop - N_RIGID * (b + 1))
        k = block.stop - block.start
        matrix = np.diag(bodies.stiffness[own])
        if shortens(bodies, b):
            added = np.zeros((k, k))
            add_tangent(bodies, b, q[block].copy(), 1.0, True, added)
            matrix += added
        K[block, block] = matrix
        C[block, block] = np.diag(bodies.damping[own])
        start, end = bodies.cross_damping_start[b : b + 2]
        if end > start:
            C[block, block] += bodies.cross_damping[start:end].reshape(k, k)
    return K, C


def held_inverse(M: FloatArray, J: FloatArray) -> FloatArray:
    """What forces accelerate while joints hold, J du = 0: M^-1 - M^-1 J^T (J M^-1 J^T)^-1 J M^-1, of any rank of J."""
    scale = 1.0 / np.sqrt(np.diag(M))  # of coordinates: metres, radians, modal ones
    Z = scale[:, None] * null_space(J * scale)
    return np.asarray(Z @ np.linalg.solve(Z.T @ M @ Z, Z.T))


def null_space(J: FloatArray) -> FloatArray:
    """(n, f) orthonormal basis of what J maps to 0."""
    if not len(J):
        return np.eye(J.shape[1])
    _, sizes, rows = np.linalg.svd(J)
    rank = int((sizes > 1e-10 * sizes.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)


def slowest_vibrations(bodies: Bodies) -> FloatArray:
    """Longest period [s] of a mode of each body, free (nb,); 0 for rigid ones."""
    found = np.zeros(len(bodies.mass))
    space = _of_space(bodies)
    rigid = space.N_RIGID if space else N_RIGID
    for b in range(len(found)):
        omega2 = bodies.stiffness[bodies.dof[b] - rigid * b : bodies.dof[b + 1] - rigid * b - rigid]
        if (omega2 > 0.0).any():
            found[b] = 2.0 * np.pi / np.sqrt(omega2[omega2 > 0.0].min())
    return found


def overbent(model: Model, q: FloatArray) -> list[int]:
    """Bodies that are stiffened by spin and so bent that foreshortening takes all their inertia: M is not positive."""
    space = _of_space(model.bodies)
    if space:
        found: list[int] = space.overbent(model.bodies, q)
        return found
    stiffened = [int(b) for b in np.flatnonzero(np.diff(model.bodies.geometric_start))]
    blocks = (body_mass_matrix(model.bodies, b, q[model.bodies.dof[b] : model.bodies.dof[b + 1]]) for b in stiffened)
    return [b for b, M in zip(stiffened, blocks, strict=True) if not np.linalg.eigvalsh(M)[0] > 0.0]


def _of_space(bodies: Any) -> ModuleType | None:
    """The module for bodies of space; None for those of the plane."""
    if not hasattr(bodies, "place"):
        return None
    from lcpflex.dynamics.spatial import mass_matrix

    return mass_matrix


def body_mass_matrix(bodies: Bodies, b: int, q: FloatArray) -> FloatArray:
    """M (3 + n, 3 + n) of body b of the plane at its own coordinates (3 + n,)."""
    n = len(q) - N_RIGID
    first = int(bodies.dof[b]) - N_RIGID * b
    modes = slice(first, first + n)
    S, modal = bodies.S[modes], q[N_RIGID:]
    A = np.array([[np.cos(q[2]), -np.sin(q[2])], [np.sin(q[2]), np.cos(q[2])]])
    x, y = bodies.moment[b] + S.T @ modal
    start, end = bodies.coupling_start[b : b + 2]
    turn = bodies.c[modes] + (modal @ bodies.coupling[start:end].reshape(n, n) if end > start else 0.0)
    M = np.eye(N_RIGID + n)
    M[:2, :2] *= bodies.mass[b]
    M[:2, 2] = M[2, :2] = A @ np.array([-y, x])
    M[2, 2] = bodies.inertia[b] + 2.0 * bodies.a[modes] @ modal + modal @ modal
    start, end = bodies.geometric_start[b : b + 2]
    if end > start:
        M[2, 2] -= modal @ bodies.geometric[start:end].reshape(n, n) @ modal
    M[:2, N_RIGID:] = A @ S.T
    M[N_RIGID:, :2] = M[:2, N_RIGID:].T
    M[2, N_RIGID:] = M[N_RIGID:, 2] = turn
    return M
