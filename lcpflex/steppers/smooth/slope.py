"""Right-hand side of motion under continuous contact forces, and what it leaves in the records.

    M udot = h + J^T lambda_J + W_N lambda_N(q, u) + W_T lambda_T(q, u),   J udot + b = 0

Contact forces are functions of the state (:mod:`lcpflex.force_laws.penalty`); only joints have unknown ones. The
vector y holds q (nq numbers), u (ndof), then accumulated: energy lost to friction, to damping of contacts, to that of
bodies, work of loads and drives [J], and the normal and tangential impulse of each declared contact [N s], the latter
a vector in space.
"""

from __future__ import annotations

import math

from lcpflex.contact.table import weight_of
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.contact_forces import (
    add_force,
    add_impulses,
    compression,
    contact_forces,
    elastic_energy,
    fill_rows,
    find_contacts,
    mobility,
    pair_force,
    pair_place,
    pair_stiffness,
    parting_time,
    states_of_friction,
    tangential_force,
)
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.joint_reactions import note_instant
from lcpflex.dynamics.joint_response import factorise_joints, solve_joints
from lcpflex.dynamics.mechanics import factorise, fill_joint_rows, forces, solve_rows, solve_vector, supply
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.configuration import rate
from lcpflex.model.arrays import Model
from lcpflex.steppers.recorded_contacts import note_compliant
from lcpflex.steppers.recorder import Recorder, store_contacts, store_state
from lcpflex.steppers.short_steps import travel_time
from lcpflex.steppers.smooth.memory import (
    CONTACT_DAMPING,
    DAMPING,
    FRICTION,
    IMPULSES,
    WORK,
    SmoothMemory,
)
from lcpflex.steppers.status import RunStatus

__all__ = ["add_powers", "horizon", "natural_frequency", "record", "slope"]


@kernel
def add_contacts(contacts: CompliantContacts, base: int, accelerations: FloatArray, out: FloatArray) -> None:
    """Contact forces to the generalised ones, in ``accelerations``; their impulses to the slope ``out``."""
    n = contacts.rows.n_contacts
    for k in range(n):
        add_force(contacts, contacts.rows.J, contacts.rows.n_joint + k, contacts.p[k, 0], accelerations)
    for j in range(contacts.rows.n_tangents):
        add_force(
            contacts, contacts.rows.J, contacts.rows.n_joint + n + j, tangential_force(contacts, j), accelerations
        )
    add_impulses(contacts, base + IMPULSES, out)


@kernel
def add_powers(work: Workspace, u: FloatArray, base: int, out: FloatArray) -> None:
    """What the forces that are there lose, and loads and drives supply, at the velocities ``u``: to the slope ``out``.

    After ``slope``, which found the forces.
    """
    contacts = work.compliant
    first = contacts.rows.n_joint
    for i in range(len(u)):
        out[base + DAMPING] -= work.free.dissipative[i] * u[i]
        out[base + WORK] += work.free.driving[i] * u[i]
    for k in range(contacts.rows.n_contacts):
        opening = row_velocity(contacts.rows.J, contacts.rows.body, first + k, contacts.rows.dof, u)
        out[base + CONTACT_DAMPING] -= (contacts.p[k, 0] - contacts.elastic[k]) * opening
    first += contacts.rows.n_contacts
    for j in range(contacts.rows.n_tangents):
        slip = row_velocity(contacts.rows.J, contacts.rows.body, first + j, contacts.rows.dof, u)
        out[base + FRICTION] -= tangential_force(contacts, j) * slip
    for r in range(len(work.scratch.residual)):
        if work.rows.rate[r] != 0.0:
            out[base + WORK] += work.impulses.p[r] * row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)


@kernel
def slope(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory, out: FloatArray) -> bool:
    """out = dy/dt; False where the table of contacts must grow.

    Contacts with their forces are left in ``work.compliant``.
    """
    nq, ndof = memory.nq, len(work.free.u)
    base = nq + ndof
    q = y[:nq]
    u = y[nq:base]
    for i in range(base, len(out)):
        out[i] = 0.0
    states = y[memory.states :].reshape(-1, states_of_friction(model))
    rates = out[memory.states :].reshape(-1, states_of_friction(model))
    contact_forces(model, q, u, states, rates, work.compliant)
    if work.compliant.needed > 0:
        return False
    n_joint = len(work.scratch.residual)
    supply(model, t, q, u, work)
    factorise(model, q, 0.0, 0.0, work)
    if n_joint > 0:
        fill_joint_rows(model, t, q, u, work.free.external, work.rows)
    forces(model, t, q, u, work)
    for i in range(ndof):
        work.free.u[i] = work.free.total[i]
    add_contacts(work.compliant, base, work.free.u, out)
    solve_vector(model, work, work.free.u)
    if n_joint > 0:
        solve_rows(model, work.rows, 0, n_joint)
        for r in range(n_joint):
            work.impulses.p[r] = -(
                row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, work.free.u) + work.rows.bias[r]
            )
        factorise_joints(work.rows)
        solve_joints(work.rows, work.impulses.p)
        apply_impulses(work.rows.solved, work.rows.body, 0, n_joint, work.impulses.p, work.rows.dof, work.free.u)
    add_powers(work, u, base, out)
    rate(model, q, u, out)
    for i in range(ndof):
        out[nq + i] = work.free.u[i]
    return True


@kernel
def natural_frequency(model: Model, work: Workspace, memory: SmoothMemory) -> float:
    """Highest sqrt(k G_nn) of the contacts that ``slope`` found [rad/s], each by itself."""
    contacts = work.compliant
    n_joint = contacts.rows.n_joint
    n = contacts.rows.n_contacts
    bristles = memory.states < len(memory.y)
    solve_rows(model, contacts.rows, n_joint, n_joint + n + (contacts.rows.n_tangents if bristles else 0))
    highest = 0.0
    for k in range(n):
        depth = -contacts.rows.table.gap[k]
        if depth > 0.0:
            place = pair_place(model, contacts.history, contacts.rows.table, k)
            stiffness = pair_stiffness(contacts.history, contacts.rows.table.law[k], place, depth)
            highest = max(highest, weight_of(contacts.rows.table, k) * stiffness * mobility(contacts, n_joint + k))
    return math.sqrt(highest)


@kernel
def horizon(
    model: Model, y: FloatArray, slope: FloatArray, margin: float, work: Workspace, memory: SmoothMemory
) -> float:
    """Longest step [s] that passes over no contact: error control does not see what no stage meets.

    It ends where the first pair nearer than ``margin`` [m] closes, and goes a part of the time of compression further,
    so that the pair is met, nor far beyond the end of an indentation. After ``slope`` at y; of no meaning where the
    table of contacts must grow.
    """
    nq = memory.nq
    q, u = y[:nq], y[nq : nq + len(work.free.u)]
    contacts = work.compliant
    table = contacts.rows.table
    longest = travel_time(model, y, slope)
    find_contacts(model, q, margin, contacts)
    fill_rows(model, q, contacts)
    for k in range(contacts.rows.n_contacts):
        gap = table.gap[k]
        r = contacts.rows.n_joint + k
        approach = -row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, u)
        if gap > 0.0 and approach > 0.0:
            solve_rows(model, contacts.rows, r, r + 1)
            depth = compression(contacts, k, approach * approach, mobility(contacts, r))
            longest = min(longest, (gap + depth) / approach)
        elif gap < 0.0 and approach < 0.0:  # where damping is clipped, nothing else tells of the end of the spring
            place = pair_place(model, contacts.history, table, k)
            if place >= 0 or pair_force(contacts.history, table.law[k], place, -gap, approach)[0] == 0.0:
                longest = min(longest, parting_time(gap, approach, memory.step))
    return longest


@kernel
def record(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory, recorder: Recorder) -> int:
    """Store the state y of time t with its contact forces; returns DONE, or why there is no room."""
    base = memory.nq + len(work.free.u)
    q = y[: memory.nq]
    u = y[memory.nq : base]
    if recorder.n_instants >= len(recorder.times):
        return RunStatus.TAPE_FULL
    needed = store_contacts(model, q, recorder)
    if not slope(model, t, y, work, memory, memory.slope):
        return RunStatus.GROW
    contacts = work.compliant
    n = contacts.rows.n_contacts
    if recorder.n_points + n > len(recorder.points) and recorder.n_points > 0:
        return RunStatus.TAPE_FULL
    if needed > len(recorder.table.key) or n > len(recorder.points):
        memory.number = max(needed, n)
        return RunStatus.GROW_TAPE
    recorder.counts.lost_friction = y[base + FRICTION]
    recorder.counts.lost_impacts = y[base + CONTACT_DAMPING]
    recorder.counts.lost_damping = y[base + DAMPING]
    recorder.counts.supplied = y[base + WORK]
    sums = recorder.total_impulse.shape[1]
    for law in range(len(recorder.total_impulse)):
        for c in range(sums):
            recorder.total_impulse[law, c] = y[base + IMPULSES + sums * law + c]
    for k in range(n if recorder.rates.now[0] == 1 else 0):
        recorder.counts.worst_penetration = max(recorder.counts.worst_penetration, -contacts.rows.table.gap[k])
    note_compliant(model, q, contacts, True, recorder)
    if len(work.scratch.residual) > 0:
        note_instant(model, work, recorder.rates.now, recorder.reactions)
    store_state(model, t, q, u, work, elastic_energy(model, contacts), recorder)
    return RunStatus.DONE
