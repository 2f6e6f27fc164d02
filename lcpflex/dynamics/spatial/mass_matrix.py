"""The mass matrix of a spatial scene in full, for what happens once in a run, and its elastic matrices."""

from __future__ import annotations

import numpy as np

from lcpflex.dynamics.spatial.inertia import PARTS
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.rotations import axes_at
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies, SpatialModel

__all__ = ["N_RIGID", "body_mass_matrix", "elastic_matrices", "mass_matrix", "overbent"]


def mass_matrix(model: SpatialModel, q: FloatArray) -> FloatArray:
    """M(q) (nu, nu), symmetric positive definite, block-diagonal over the bodies; T = u^T M u / 2 [J].

    M_RR = m I,  M_Rtheta = -A d~,  M_Rf = A S,  M_thetatheta = J,  M_thetaf = C,  M_ff = I: rows of translation in
    world axes, of rotation in body axes (:mod:`lcpflex.dynamics.spatial.inertia`).
    """
    dof = model.bodies.dof
    M = np.zeros((dof[-1], dof[-1]))
    for b in range(len(dof) - 1):
        block = slice(dof[b], dof[b + 1])
        M[block, block] = body_mass_matrix(model.bodies, b, q)
    return M


def elastic_matrices(bodies: SpatialBodies) -> tuple[FloatArray, FloatArray]:
    """K and C (nu, nu) of all bodies: second derivatives of their elastic energy, and their damping."""
    n = int(bodies.dof[-1])
    K, C = np.zeros((n, n)), np.zeros((n, n))
    for b in range(len(bodies.dof) - 1):
        block = slice(int(bodies.dof[b]) + N_RIGID, int(bodies.dof[b + 1]))
        own = slice(block.start - N_RIGID * (b + 1), block.stop - N_RIGID * (b + 1))
        k = block.stop - block.start
        K[block, block] = np.diag(bodies.stiffness[own])
        C[block, block] = np.diag(bodies.damping[own])
        start, end = bodies.cross_damping_start[b : b + 2]
        if end > start:
            C[block, block] += bodies.cross_damping[start:end].reshape(k, k)
    return K, C


def overbent(bodies: SpatialBodies, q: FloatArray) -> list[int]:
    """Bodies that are stiffened by spin and so bent that foreshortening takes all their inertia: M is not positive."""
    stiffened = np.flatnonzero(np.diff(bodies.geometric_start)).tolist() if len(bodies.geometric) else []
    return [b for b in stiffened if not np.linalg.eigvalsh(body_mass_matrix(bodies, b, q))[0] > 0.0]


def body_mass_matrix(bodies: SpatialBodies, b: int, q: FloatArray) -> FloatArray:
    """M (6 + n, 6 + n) of body b at the configuration q of all."""
    first, last = (int(bodies.dof[b + i]) - N_RIGID * (b + i) for i in (0, 1))
    i = int(bodies.place[b])
    A, eta = axes_at(q, i), q[i + N_PLACE : i + N_PLACE + last - first]
    S, P1 = bodies.S[first:last], bodies.first[first:last].reshape(-1, 3, 3)
    n2 = int(bodies.second_modes[b])
    start = int(bodies.products_start[b])
    products = bodies.products[start : start + 9 * n2 * n2].reshape(n2, n2, 3, 3)
    Y = P1.copy()
    Y[:n2] += np.einsum("l,lkij->kij", eta[:n2], products)
    P = bodies.second[b] + np.einsum("k,kij->ij", eta, P1 + Y.transpose(0, 2, 1))
    C = np.stack([Y[:, 1, 2] - Y[:, 2, 1], Y[:, 2, 0] - Y[:, 0, 2], Y[:, 0, 1] - Y[:, 1, 0]], axis=1)
    x, y, z = bodies.moment[b] + S.T @ eta
    M = np.eye(N_RIGID + last - first)
    M[:3, :3] *= bodies.mass[b]
    M[:3, 3:6] = -A @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    M[3:6, 3:6] = np.trace(P) * np.eye(3) - 0.5 * (P + P.T)
    start, end = bodies.geometric_start[b : b + 2] if len(bodies.geometric) else (0, 0)
    if end > start:
        G = bodies.geometric[start:end].reshape(last - first, last - first, PARTS)
        less = np.einsum("k,l,kli->i", eta, eta, G)
        M[3:6, 3:6] -= less[[0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(3, 3)
    M[:3, 6:], M[3:6, 6:] = A @ S.T, C.T
    M[3:, :3], M[6:, 3:6] = M[:3, 3:].T, C
    return M
