"""What the massless-boundary scheme writes down in space: see :mod:`lcpflex.steppers.massless_boundary.booked`."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.spatial.pairs import contact_point
from lcpflex.contact.spatial.table import side_of
from lcpflex.dynamics.position import slip_in
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import compose, exponential, rotation_matrix, transform, unit
from lcpflex.model.spatial import N_PLACE, SpatialModel
from lcpflex.steppers.massless_boundary.booked import STICKING
from lcpflex.steppers.massless_boundary.stored import combined
from lcpflex.steppers.recorded_contacts import friction_state
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.records import friction_vector, note_spatial_contact

__all__ = ["move_frame", "note_forces", "sum_forces"]


@kernel
def sum_forces(scheme: Any, work: SpatialWork, recorder: Recorder) -> None:
    """Add the present contact forces to ``scheme.force``, of the declared contacts: friction as a vector."""
    table, n, p = work.rows.table, work.rows.n_contacts, work.impulses.p
    for k in range(n):
        law, j = table.law[k], work.posed.tangent_of[k]
        scheme.force[law, 0] += work.impulses.normal[k]
        if j >= 0:
            r, side = work.rows.n_joint + n + j, side_of(recorder.table, law, table.body[k, 0])
            friction = friction_vector(table, k, p[r], p[r + 1])
            for i in range(3):
                scheme.force[law, 1 + i] += side * friction[i]


@kernel
def note_forces(model: SpatialModel, q: FloatArray, work: SpatialWork, recorder: Recorder) -> None:
    """Add the touching points with their forces to the instant about to be stored."""
    table, n, p = work.rows.table, work.rows.n_contacts, work.impulses.p
    for k in range(n):
        normal, j = work.impulses.normal[k], work.posed.tangent_of[k]
        if not normal > 0.0:
            continue
        first, second, slip = 0.0, 0.0, 1.0
        if j >= 0:
            r = work.rows.n_joint + n + j
            first, second = p[r], p[r + 1]
            slip = math.hypot(slip_in(work, j), slip_in(work, j + 1))
        state = friction_state(normal, math.hypot(first, second), work.rows.mu[k], slip, STICKING)
        place = contact_point(model, q, table, k)
        note_spatial_contact(recorder, table, k, place, normal, first, second, state)


@kernel
def move_frame(model: SpatialModel, scheme: Any, start: int, b: int, n: int, q: FloatArray) -> None:
    """The frame of body b in q, as the scheme has it, along with static coordinates, which have no velocity."""
    i, e = model.bodies.place[b], model.bodies.place[b] + N_PLACE
    x, y, z = (
        combined(scheme, start, 0, e, n, scheme.q),
        combined(scheme, start, 1, e, n, scheme.q),
        combined(scheme, start, 2, e, n, scheme.q),
    )
    turn = exponential(
        combined(scheme, start, 3, e, n, scheme.q),
        combined(scheme, start, 4, e, n, scheme.q),
        combined(scheme, start, 5, e, n, scheme.q),
    )
    x, y, z = transform(rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6]), x, y, z)
    q[i] += x
    q[i + 1] += y
    q[i + 2] += z
    w, x, y, z = unit(compose((q[i + 3], q[i + 4], q[i + 5], q[i + 6]), turn))
    q[i + 3], q[i + 4], q[i + 5], q[i + 6] = w, x, y, z
