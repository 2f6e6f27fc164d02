"""The mass matrix of a deformed spatial body by its integrals, in body axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.bodies.spatial.checks import skew, skew_part

__all__ = ["mass_matrix", "stretch_by_spin", "velocity_columns"]


def mass_matrix(body: Any, eta: Any) -> Any:
    """(6 + n, 6 + n) at the modal coordinates eta (n,), axes of the body frame."""
    n, n2 = body.modes, body.second_order_modes
    first = body.first.reshape(n, 3, 3)
    P2 = np.zeros((n, n, 3, 3))
    P2[:n2, :n2] = body.products.reshape(n2, n2, 3, 3)
    Y = first + np.einsum("l,lkij->kij", eta, P2)
    P = body.second + np.einsum("k,kij->ij", eta, first + Y.transpose(0, 2, 1))
    M = np.eye(6 + n)
    M[:3, :3] *= body.mass
    M[:3, 3:6] = -skew(body.moment + eta @ body.S)
    M[:3, 6:] = body.S.T
    M[3:6, 3:6] = np.trace(P) * np.eye(3) - P
    M[3:6, 6:] = skew_part(Y.reshape(n, 9)).T
    upper = np.triu_indices(6 + n)
    M.T[upper] = M[upper]
    return M


def stretch_by_spin(body: Any, omega: Any, x: float) -> float:
    """Displacement along x of the material at (x, 0, 0) by a steady spin: stiffness eta = |w|^2 tr P1 - w.P1 w."""
    first = body.first.reshape(-1, 3, 3)
    force = np.trace(first, axis1=1, axis2=2) * (omega @ omega) - np.einsum("i,kij,j->k", omega, first, omega)
    return float((force / body.stiffness) @ body.locate(x, 0.0, 0.0).phi[:, 0])


def velocity_columns(places: Any, phi: Any, eta: Any) -> Any:
    """(3 N, 6 + n) velocities of N material points by those of the body; phi (N, n, 3)."""
    n = phi.shape[1]
    s = places + np.einsum("ikj,k->ij", phi, eta)
    L = np.zeros((len(s), 3, 6 + n))
    L[:, :, :3] = np.eye(3)
    L[:, :, 3:6] = np.array([-skew(si) for si in s])
    L[:, :, 6:] = phi.transpose(0, 2, 1)
    return L.reshape(-1, 6 + n)
