"""Forces of compliant contacts in space: what is not as in the plane (:mod:`lcpflex.dynamics.contact_forces`).

Friction is a vector in the tangent plane, along two rows. Its states are in :mod:`lcpflex.dynamics.spatial.bristles`.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.spatial.table import side_of
from lcpflex.dynamics.contact_forces import pair_place
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import fill_contact_rows
from lcpflex.dynamics.spatial.bristles import AXIS, DWELL, STATES, direction, spin_of_bristles, turn_of
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.force_laws.friction.spatial_kernels import bristle_slopes, friction_pull
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross, rotation_matrix
from lcpflex.kinematics.spatial.vectors import added, row_vector, scaled, turned_back

__all__ = [
    "add_impulses",
    "fill_rows",
    "find_friction",
    "states_of_friction",
    "tangential_force",
    "tangential_vector",
]

SUMS = 4  # of a declared contact: impulse along normals, and that of friction, world axes


@kernel
def fill_rows(model: Any, q: FloatArray, contacts: SpatialWork) -> None:
    """Rows of the contacts found, those of friction halfway between the surfaces: see the plane.

    A point moved by -g/2 n on body i and by g/2 n on body j turns with its body: both rows change by the same moment.
    """
    n = contacts.rows.n_contacts
    contacts.rows.n_tangents = fill_contact_rows(model, q, n, contacts.rows.n_joint, contacts.rows)
    if len(model.bodies.mass) == 0:
        return
    table, row_body = contacts.rows.table, contacts.rows.body
    first = contacts.rows.n_joint + n
    for j in range(contacts.rows.n_tangents):
        k = contacts.rows.tangent[j]
        normal, along = row_vector(table.normal, k), row_vector(table.tangent, k)
        if j % 2 == 1:
            along = cross(normal, along)
        moment = scaled(-0.5 * table.gap[k], cross(normal, along))
        for i in range(2):
            b = row_body[first + j, i]
            if b >= 0:
                d = model.bodies.place[b] + 3
                local = turned_back(rotation_matrix(q[d], q[d + 1], q[d + 2], q[d + 3]), moment)
                contacts.rows.J[first + j, i, 3] += local[0]
                contacts.rows.J[first + j, i, 4] += local[1]
                contacts.rows.J[first + j, i, 5] += local[2]


@kernel
def states_of_friction(model: Any) -> int:
    """How many states of friction each place has."""
    return STATES


@kernel
def tangential_force(contacts: SpatialWork, j: int) -> float:
    """Friction along tangential row j [N]."""
    return contacts.p[contacts.rows.tangent[j], 1 + j % 2]


@kernel
def find_friction(
    model: Any, q: FloatArray, u: FloatArray, states: FloatArray, rates: FloatArray, contacts: SpatialWork
) -> None:
    """Friction forces at the slip velocities of the state (q, u), after ``normal_forces``: see the plane.

    ``states`` (places, 4): of the friction laws that have some; none: (0, 4). Their derivatives go to ``rates``.
    """
    friction_forces(model, q, u, states, rates, contacts)


@late_kernel
def friction_forces(
    model: Any, q: FloatArray, u: FloatArray, states: FloatArray, rates: FloatArray, contacts: SpatialWork
) -> None:
    """``find_friction`` where there are contacts."""
    history, table = contacts.history, contacts.rows.table
    first = contacts.rows.n_joint + contacts.rows.n_contacts
    for j in range(0, contacts.rows.n_tangents, 2):
        k = contacts.rows.tangent[j]
        law = table.law[k]
        kinds, p = history.kinds[law], history.parameters[law]
        mu, normal = contacts.rows.mu[k], contacts.p[k, 0]
        v = row_velocity(contacts.rows.J, contacts.rows.body, first + j, contacts.rows.dof, u)
        w = row_velocity(contacts.rows.J, contacts.rows.body, first + j + 1, contacts.rows.dof, u)
        contacts.slip[j] = v
        contacts.slip[j + 1] = w
        contacts.sticks[k] = 1 if math.hypot(v, w) < history.slip_speed[law] else 0
        place = pair_place(model, history, table, k) if len(states) > 0 and normal > 0.0 else -1
        if place < 0:
            force = friction_pull(kinds, p, (v, w), normal, mu, (0.0, 0.0), 0.0)
            contacts.p[k, 1] = force[0]
            contacts.p[k, 2] = force[1]
            continue
        axis = int(states[place, AXIS])
        along = direction(model, q, table, k, axis)
        c, s = turn_of(row_vector(table.tangent, k), along, row_vector(table.normal, k))
        slip = (c * v + s * w, c * w - s * v)
        bristle, dwell = (states[place, 0], states[place, 1]), states[place, DWELL]
        change = bristle_slopes(kinds, p, slip, mu, bristle, dwell)
        spin = spin_of_bristles(model, q, u, table, k, axis)
        rates[place, 0] = change[0] - spin * bristle[1]
        rates[place, 1] = change[1] + spin * bristle[0]
        rates[place, DWELL] = change[2]
        force = friction_pull(kinds, p, slip, normal, mu, bristle, dwell)
        contacts.p[k, 1] = c * force[0] - s * force[1]
        contacts.p[k, 2] = s * force[0] + c * force[1]


@kernel
def tangential_vector(contacts: SpatialWork, k: int, first: float, second: float) -> Vector:
    """first t1 + second t2 of entry k, world axes."""
    along = row_vector(contacts.rows.table.tangent, k)
    across = cross(row_vector(contacts.rows.table.normal, k), along)
    return added(scaled(first, along), scaled(second, across))


@kernel
def add_impulses(contacts: SpatialWork, first: int, out: FloatArray) -> None:
    """Add the forces to the rates of the impulses of declared contacts, from ``first`` on: see the plane."""
    for k in range(contacts.rows.n_contacts):
        at = first + SUMS * contacts.rows.table.law[k]
        side = side_of(contacts.rows.table, contacts.rows.table.law[k], contacts.rows.table.body[k, 0])
        friction = tangential_vector(contacts, k, side * contacts.p[k, 1], side * contacts.p[k, 2])
        out[at] += contacts.p[k, 0]
        for c in range(3):
            out[at + 1 + c] += friction[c]
