"""What a run writes down of contacts in space: touching points, and sums of forces and impulses.

A pair of features may have either surface of its contact on its side i. What is written down is the force on the body
of the first surface as it was declared (of a pair by a rule: of the earlier one): friction as a vector in world axes,
and at touching points the normal towards that body. The force of a point on that body is N n + F, on the other one
-(N n + F).
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.pairs import contact_point
from lcpflex.contact.spatial.table import SpatialContactTable, side_of
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.model.spatial import SpatialModel
from lcpflex.steppers.recorded_contacts import friction_state
from lcpflex.steppers.recorder import Recorder

__all__ = [
    "add_compliant_impulse",
    "add_impulse",
    "friction_vector",
    "note_compliant",
    "note_impulses",
    "note_spatial_contact",
]

STICKING_SPEED = 1e-9  # [m/s] as in the plane
LEFT = 1e-6  # of the terms of a free velocity: what answers that count as solved may leave of it


@kernel
def friction_vector(table: SpatialContactTable, k: int, first: float, second: float) -> Vector:
    """first t1 + second t2 of entry k, world axes; t2 = n x t1."""
    nx, ny, nz = table.normal[k, 0], table.normal[k, 1], table.normal[k, 2]
    x, y, z = table.tangent[k, 0], table.tangent[k, 1], table.tangent[k, 2]
    return (
        first * x + second * (ny * z - nz * y),
        first * y + second * (nz * x - nx * z),
        first * z + second * (nx * y - ny * x),
    )


@kernel
def add_impulse(work: SpatialWork, r: int, p: float, recorder: Recorder) -> None:
    """Add the impulse p of contact row r, counted behind those of joints: normal ones, and friction as a vector."""
    n = work.rows.n_contacts
    sums = recorder.total_impulse
    if r < n:
        sums[work.rows.table.law[r], 0] += p
        return
    k = work.rows.tangent[r - n]
    second = work.posed.tangent_of[k] != r - n
    law = work.rows.table.law[k]
    p *= side_of(recorder.table, law, work.rows.table.body[k, 0])
    x, y, z = friction_vector(work.rows.table, k, 0.0 if second else p, p if second else 0.0)
    sums[law, 1] += x
    sums[law, 2] += y
    sums[law, 3] += z


@kernel
def add_compliant_impulse(contacts: SpatialWork, k: int, step: float, recorder: Recorder) -> None:
    """Add what compliant contact k has given in a step to the sums of its declared contact."""
    sums, law = recorder.total_impulse, contacts.rows.table.law[k]
    side = step * side_of(recorder.table, law, contacts.rows.table.body[k, 0])
    x, y, z = friction_vector(contacts.rows.table, k, side * contacts.p[k, 1], side * contacts.p[k, 2])
    sums[law, 0] += step * contacts.p[k, 0]
    sums[law, 1] += x
    sums[law, 2] += y
    sums[law, 3] += z


@kernel
def note_spatial_contact(
    recorder: Recorder,
    table: SpatialContactTable,
    k: int,
    place: Vector,
    force_n: float,
    first: float,
    second: float,
    state: int,
) -> None:
    """Add entry k, touching at ``place`` with forces along n, t1 and t2, to the instant about to be stored."""
    law = table.law[k]
    side = side_of(recorder.table, law, table.body[k, 0])
    x, y, z = friction_vector(table, k, side * first, side * second)
    recorder.now_force[law, 0] += force_n
    recorder.now_force[law, 1] += x
    recorder.now_force[law, 2] += y
    recorder.now_force[law, 3] += z
    recorder.now_state[law] = max(recorder.now_state[law], state)
    row = recorder.n_points
    if row < len(recorder.points):
        points = recorder.points
        points[row, 0] = recorder.n_instants
        points[row, 1] = law
        for i in range(3):
            points[row, 2 + i] = place[i]
            points[row, 5 + i] = side * table.normal[k, i]
        points[row, 8] = force_n
        points[row, 9] = x
        points[row, 10] = y
        points[row, 11] = z
        points[row, 12] = table.area[k]
        points[row, 13] = state
        recorder.n_points = row + 1


@kernel
def note_impulses(
    model: SpatialModel, q: FloatArray, u: FloatArray, step: float, work: SpatialWork, recorder: Recorder
) -> None:
    """Add the touching points of the step to the instant about to be stored."""
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    for k in range(n):
        p_n = work.impulses.p[n_joint + k]
        if not p_n > 0.0:
            continue
        first, second, slip, rest, mu = 0.0, 0.0, 1.0, 0.0, 0.0
        j = work.posed.tangent_of[k]
        if j >= 0:
            r = n_joint + n + j
            first, second = work.impulses.p[r], work.impulses.p[r + 1]
            slip = abs(row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u))
            slip += abs(row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, u))
            rest = max(STICKING_SPEED, LEFT * (work.free.terms[n + j] + work.free.terms[n + j + 1]))
            mu = work.rows.mu[k]
        state = friction_state(p_n, math.hypot(first, second), mu, slip, rest)
        place = contact_point(model, q, work.rows.table, k)
        note_spatial_contact(recorder, work.rows.table, k, place, p_n / step, first / step, second / step, state)


@kernel
def note_compliant(
    model: SpatialModel, q: FloatArray, contacts: SpatialWork, touching: bool, recorder: Recorder
) -> None:
    """Add the compliant contacts with the forces found at q; ``touching``: those without a force, too."""
    table = contacts.rows.table
    for k in range(contacts.rows.n_contacts):
        if touching or table.gap[k] < 0.0:
            place = contact_point(model, q, table, k)
            p = contacts.p[k]
            state = STICK if contacts.sticks[k] == 1 and (touching or p[0] > 0.0) else SLIP
            note_spatial_contact(recorder, table, k, place, p[0], p[1], p[2], state)
