"""Contacts of a spatial scene at one state: rows of both tangents, and the contact problem with cones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.contact.narrow_phase.feature import contact_bias
from lcpflex.contact.rows import contact_point, contact_rows
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.solvers.contact.spatial import SpatialContactProblem

if TYPE_CHECKING:
    from lcpflex.compile.state_mechanics import StateMechanics
    from lcpflex.steppers.system import System

__all__ = ["accelerations", "impulses", "spatial_contacts"]


def spatial_contacts(system: System, q: FloatArray, u: FloatArray, table: Any, m: int) -> dict[str, Any]:
    """Geometry, rows (m, 3, 2, width) and biases (m, 3) of the first m entries of a table.

    Normals are towards the body of the surface that was declared first, and t2 = n x t1.
    """
    model = system.model
    width = int(np.diff(model.bodies.dof).max(initial=1))
    rows, w, places = np.zeros((m, 3, 2, width)), np.zeros((m, 3)), np.zeros((m, 3))
    for k in range(m):
        contact_rows(model, q, table, k, rows[k, 0], rows[k, 1:])
        w[k] = contact_bias(model, q, u, table, k)
        places[k] = contact_point(model, q, table, k)
    side = np.array([_side(system, int(table.law[k]), int(table.body[k, 0])) for k in range(m)])
    normals, first = side[:, None] * table.normal[:m], table.tangent[:m].copy()
    rows[:, 1] *= side[:, None, None]  # t2 turns with the normal, and so does what slips on what
    w[:, 1] *= side
    tangents = np.stack([first, np.cross(normals, first)], axis=1)
    return {"places": places, "normals": normals, "tangents": tangents, "rows": rows, "w": w}


def _side(system: System, law: int, i: int) -> float:
    """1 where body i is that of the first surface of a contact, else -1."""
    contacts: Any = system.model.contacts
    of_law: IntArray = contacts.law_surface
    surface = int(of_law[law, 0]) if law < len(of_law) else int(system.rule_pairs.pair[law, 0])
    return 1.0 if int(contacts.surface_body[surface]) == i else -1.0


def accelerations(at: StateMechanics) -> SpatialContactProblem:
    """That of the contacts N: rows n, t1, t2 of each, friction of sliding ones in the columns of their normals."""
    N = at.N
    rows = _rows(at, N)
    columns = rows.copy()
    sliding = np.isin(N, at.G)
    for i in np.flatnonzero(sliding).tolist():
        k = int(N[i])
        size = float(np.linalg.norm(at.slip_speeds[k]))
        if size > 0.0:
            columns[:, 3 * i] -= at.friction[k] / size * (at.W_T[:, k] @ at.slip_speeds[k])
    known = np.column_stack([at.w_N[N], at.w_T[N]]).ravel()
    held, kept = at.condensed(np.column_stack([columns, at.h]), at.gamma)
    friction = np.where(sliding, 0.0, at.friction[N])
    return _problem(at, rows.T @ held[:, :-1], rows.T @ (held[:, -1] + kept) + known, friction, N)


def impulses(at: StateMechanics) -> SpatialContactProblem:
    """That of an impact of all closed contacts, by Newton's law."""
    C = at.C
    rows = _rows(at, C)
    held, kept = at.condensed(rows, at.joint_rates)
    reflected = np.where(np.abs(at.gap_rates[C]) > at.velocity_threshold, at.restitution[C], 0.0)
    before = np.column_stack(
        [reflected * at.gap_rates[C], at.tangential_restitution[C, None] * at.slip_speeds[C]]
    ).ravel()
    return _problem(at, rows.T @ held, rows.T @ (at.u - kept) + before, at.friction[C], C)


def _rows(at: StateMechanics, chosen: IntArray) -> FloatArray:
    """(n, 3 k): W_N and both W_T of each contact in turn."""
    whole = np.concatenate([at.W_N[:, chosen, None], at.W_T[:, chosen]], axis=2)
    return np.asarray(whole.reshape(len(at.W_N), 3 * len(chosen)))


def _problem(
    at: StateMechanics, G: FloatArray, free: FloatArray, friction: FloatArray, chosen: IntArray
) -> SpatialContactProblem:
    return SpatialContactProblem(G, free, friction, tuple((at.contacts[k], int(k)) for k in chosen))
