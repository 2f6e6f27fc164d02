"""Verlet's method in space: its kick, and the states of friction."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.contact_forces import mobility, pair_place
from lcpflex.dynamics.spatial.bristles import AXIS, DWELL, STATES, direction, turn_of
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.friction.spatial_kernels import bristle_slopes, friction_pull
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.vectors import row_vector
from lcpflex.steppers.smooth.explicit import SMALL
from lcpflex.steppers.smooth.memory import IMPULSES, SmoothMemory
from lcpflex.steppers.smooth.slope import slope

__all__ = ["kick_again", "relax"]


@kernel
def kick_again(model: Any, h: float, work: Workspace, memory: SmoothMemory) -> None:
    """Make the kick of a step of length h anew, with the mean of the velocities before and behind the first one.

    omega x J omega at the velocity before it alone gains energy and is of order 1; so it is of order 2.
    """
    base = memory.nq + len(work.free.u)
    for i in range(len(memory.end)):
        memory.at[i] = memory.end[i]
    for i in range(memory.nq, base):
        memory.at[i] = 0.5 * (memory.y[i] + memory.end[i])
    slope(model, memory.time + 0.5 * h, memory.at, work, memory, memory.slope)  # with tables that are large enough
    for i in range(base, base + IMPULSES):  # what forces do is told by who makes the step
        memory.slope[i] = 0.0
    for i in range(memory.nq, memory.states):
        memory.end[i] = memory.y[i] + h * memory.slope[i]


@kernel
def relax(model: Any, h: float, work: Workspace, memory: SmoothMemory) -> float:
    """Let the states of friction go on by h [s], by linearly implicit steps: see the plane.

    The rate of a component of a bristle depends on no other one.
    """
    contacts, y = work.compliant, memory.end
    table: Any = contacts.rows.table
    history = contacts.history
    first = contacts.rows.n_joint + contacts.rows.n_contacts
    highest = 0.0
    for j in range(0, contacts.rows.n_tangents, 2):
        k = contacts.rows.tangent[j]
        place = pair_place(model, history, table, k)
        normal, mu = contacts.p[k, 0], contacts.rows.mu[k]
        if place < 0 or not normal > 0.0:
            continue
        law = table.law[k]
        kinds, p = history.kinds[law], history.parameters[law]
        at = memory.states + STATES * place
        along = direction(model, y[: memory.nq], table, k, int(y[at + AXIS]))
        c, s = turn_of(row_vector(table.tangent, k), along, row_vector(table.normal, k))
        v, w = contacts.slip[j], contacts.slip[j + 1]
        slip = (c * v + s * w, c * w - s * v)
        stiff = max(mobility(contacts, first + j), mobility(contacts, first + j + 1))
        bristle, held = (y[at], y[at + 1]), y[at + DWELL]
        before = friction_pull(kinds, p, slip, normal, mu, bristle, held)
        still = bristle_slopes(kinds, p, slip, mu, bristle, held)
        for i in range(AXIS):
            rate = memory.slope[at + i]
            move = SMALL * (abs(y[at + i]) + h * abs(rate))
            if not move > 0.0:
                continue
            z = (bristle[0] + (move if i == 0 else 0.0), bristle[1] + (move if i == 1 else 0.0))
            dwell = held + (move if i == DWELL else 0.0)
            slope_of_rate = (bristle_slopes(kinds, p, slip, mu, z, dwell)[i] - still[i]) / move
            if i < DWELL:
                force = friction_pull(kinds, p, slip, normal, mu, z, dwell)
                change = math.hypot(force[0] - before[0], force[1] - before[1])
                highest = max(highest, change / move * stiff)
            y[at + i] += h * rate / (1.0 - h * min(slope_of_rate, 0.0))
    return math.sqrt(highest)
