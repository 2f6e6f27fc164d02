"""Right-hand side of motion under continuous contact forces, and what it leaves in the records.

    M udot = h + J^T lambda_J + W_N lambda_N(q, u) + W_T lambda_T(q, u),   J udot + b = 0

Contact forces are functions of the state (:mod:`lcpflex.force_laws.penalty`); only joints have unknown ones. The
vector y holds q, u, then accumulated: energy lost to friction, to damping of contacts, to that of bodies, work of
loads and drives [J], and the normal and tangential impulse of each declared contact [N s].
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.contact.concave_corners import yield_to_deeper
from lcpflex.contact.detection import detect
from lcpflex.contact.rows import contact_point
from lcpflex.dynamics.contact_memory import pair_energy, pair_force, pair_place, pair_stiffness
from lcpflex.dynamics.delassus import apply_impulses, cholesky, delassus, dot, joint_impulses, row_velocity
from lcpflex.dynamics.mechanics import (
    energies,
    factorise,
    fill_contact_rows,
    forces,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.elastic.kernels import indentation_of
from lcpflex.force_laws.friction.kernels import bristle_rates, friction_force
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.model.arrays import SLIP, STICK, Model
from lcpflex.steppers.recorder import Tape, note_contact, store_contacts, store_state
from lcpflex.steppers.smooth.memory import (
    CONTACT_DAMPING,
    DAMPING,
    FRICTION,
    IMPULSES,
    WORK,
    SmoothMemory,
)
from lcpflex.steppers.status import RunStatus

__all__ = ["horizon", "mobility", "natural_frequency", "record", "slope"]


TURN = 0.25  # [rad] in a step
ONSET = 0.5  # of the time in which a contact would reach its largest indentation: how far a step may go into it
LEAVING = 1.001  # times that in which a contact would part at its present rate
LEAST_SHARE = 1e-3  # of the step before, below which that does not shorten one


@kernel
def add_row(work: Workspace, r: int, force: float) -> None:
    """Add W_r force to the generalised forces, which are in ``work.free_u``."""
    for i in range(2):
        b = work.row_body[r, i]
        if b >= 0:
            d = work.dof[b]
            for k in range(work.dof[b + 1] - d):
                work.free_u[d + k] += work.rows[r, i, k] * force


@kernel
def share_place(work: Workspace) -> None:
    """Let friction act on both bodies at one place, halfway between their surfaces.

    At the surfaces themselves, which penetrate, it would be a couple, and angular momentum would be made of nothing.
    """
    first = work.n_joint + work.n_contacts
    for j in range(work.n_tangents):
        for i in range(2):
            if work.row_body[first + j, i] >= 0:
                work.rows[first + j, i, 2] += 0.5 * work.table.gap[work.tangent[j]]


@kernel
def press(
    model: Model, y: FloatArray, u: FloatArray, work: Workspace, memory: SmoothMemory, base: int, out: FloatArray
) -> None:
    """Contact forces of the rows laid, to ``work.p`` and ``work.free_u``; what they do to the rest of y."""
    n_joint = work.n_joint
    n = work.n_contacts
    table = work.table
    contacts = memory.contacts
    impulses = base + IMPULSES
    for k in range(n):
        r = n_joint + k
        law = table.law[k]
        depth = max(-table.gap[k], 0.0)
        rate = -row_velocity(work.rows, work.row_body, r, work.dof, u)
        force = 0.0
        if depth > 0.0:
            place = pair_place(model, contacts, table, k)
            force, elastic = pair_force(contacts, law, place, depth, rate)
            out[base + CONTACT_DAMPING] += (force - elastic) * rate
        work.p[r] = force
        add_row(work, r, force)
        out[impulses + 2 * law] += force
    states = memory.states
    for j in range(work.n_tangents):
        r = n_joint + n + j
        k = work.tangent[j]
        law = table.law[k]
        slip = row_velocity(work.rows, work.row_body, r, work.dof, u)
        normal = work.p[n_joint + k]
        bristle = 0.0
        dwell = 0.0
        if states < len(y):
            place = pair_place(model, contacts, table, k)
            if place >= 0 and normal > 0.0:
                at = states + 2 * place
                bristle = y[at]
                dwell = y[at + 1]
                rates = bristle_rates(
                    contacts.kinds[law], contacts.parameters[law], slip, normal, work.mu[k], bristle, dwell
                )
                out[at] = rates[0]
                out[at + 1] = rates[1]
        force = friction_force(contacts.kinds[law], contacts.parameters[law], slip, normal, work.mu[k], bristle, dwell)
        work.p[r] = force
        add_row(work, r, force)
        out[impulses + 2 * law + 1] += force
        out[base + FRICTION] -= force * slip


@kernel
def slope(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory, out: FloatArray) -> int:
    """out = dy/dt; returns the number of touching pairs. One above the capacity of the table: it must grow.

    Forces of joints, then normal and tangential ones of contacts are left in ``work.p``, the contacts in the table.
    """
    ndof = len(work.free_u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    n = detect(model, q, 0.0, work.table)
    if n > len(work.table.key):
        return n
    yield_to_deeper(work.table, n)
    n_joint = len(work.residual)
    supply(model, t, q, u, work)
    factorise(model, q, 0.0, 0.0, work)
    if n_joint > 0:
        joint_rows(model, t, q, u, work.external, work.rows, work.row_body, work.rate, work.bias)
    work.n_joint = n_joint
    work.n_contacts = n
    work.n_tangents = fill_contact_rows(model, q, n, n_joint, work)
    if len(model.bodies.mass) > 0:
        share_place(work)
    forces(model, t, q, u, work)
    base = 2 * ndof
    for i in range(base, len(out)):
        out[i] = 0.0
    for i in range(ndof):
        work.free_u[i] = work.total[i]
        out[i] = u[i]
        out[base + DAMPING] -= work.dissipative[i] * u[i]
        out[base + WORK] += work.driving[i] * u[i]
    press(model, y, u, work, memory, base, out)
    solve_vector(model, work, work.free_u)
    if n_joint > 0:
        first = int(np.int64(0))  # a literal would have kernels compiled once more
        solve_rows(model, work, first, n_joint)
        for r in range(n_joint):
            work.free[r] = row_velocity(work.rows, work.row_body, r, work.dof, work.free_u) + work.bias[r]
        delassus(work.rows, work.solved, work.row_body, n_joint, work.G)
        cholesky(work.G, n_joint, work.lower)
        joint_impulses(work.free, n_joint, n_joint, work.lower, work.share, work.p)
        apply_impulses(work.solved, work.row_body, first, n_joint, work.p, work.dof, work.free_u)
        for r in range(n_joint):
            if work.rate[r] != 0.0:
                out[base + WORK] += work.p[r] * row_velocity(work.rows, work.row_body, r, work.dof, u)
    for i in range(ndof):
        out[ndof + i] = work.free_u[i]
    return n


@kernel
def mobility(work: Workspace, r: int) -> float:
    """G_nn of row r [1/kg], whose A^-1 row is known, without joints: not less than with them."""
    total = 0.0
    first = int(np.int64(0))  # a literal would have dot compiled once more
    for i in range(2):
        if work.row_body[r, i] >= 0:
            total += dot(work.rows[r, i], work.solved[r, i], first, work.rows.shape[2])
    return total


@kernel
def natural_frequency(model: Model, work: Workspace, memory: SmoothMemory) -> float:
    """Highest sqrt(k G_nn) of the contacts that ``slope`` found [rad/s], each by itself."""
    n_joint = work.n_joint
    n = work.n_contacts
    bristles = memory.states < len(memory.y)
    solve_rows(model, work, n_joint, n_joint + n + (work.n_tangents if bristles else 0))
    highest = 0.0
    for k in range(n):
        law = work.table.law[k]
        if work.table.gap[k] < 0.0:
            place = pair_place(model, memory.contacts, work.table, k)
            stiffness = pair_stiffness(memory.contacts, law, place, -work.table.gap[k])
            highest = max(highest, stiffness * mobility(work, n_joint + k))
    return math.sqrt(highest)


@kernel
def travel_time(model: Model, y: FloatArray, slope: FloatArray) -> float:
    """Time [s] in which no body turns by more than TURN nor travels farther than the extent of the smallest surface."""
    size = math.inf
    for extent in model.contacts.surface_extent:
        if extent > 0.0:
            size = min(size, extent)
    longest = math.inf
    ndof = model.bodies.dof[len(model.bodies.dof) - 1]
    for b in range(len(model.bodies.mass)):
        d = ndof + model.bodies.dof[b]
        spin = abs(y[d + 2]) + math.sqrt(TURN * abs(slope[d + 2]))
        if spin > 0.0:
            longest = min(longest, TURN / spin)
        if size < math.inf:
            speed = math.hypot(y[d], y[d + 1]) + math.sqrt(size * math.hypot(slope[d], slope[d + 1]))
            if speed > 0.0:
                longest = min(longest, size / speed)
    return longest


@kernel
def horizon(
    model: Model, y: FloatArray, slope: FloatArray, margin: float, work: Workspace, memory: SmoothMemory
) -> float:
    """Longest step [s] that passes over no contact: error control does not see what no stage meets.

    It ends where the first pair nearer than ``margin`` [m] closes, and goes ONSET of the time of compression further,
    so that the pair is met, nor far beyond the end of an indentation. After ``slope`` at y. Negative: the table must
    hold as many entries.
    """
    ndof = len(work.free_u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    longest = travel_time(model, y, slope)
    n_joint = len(work.residual)
    n = detect(model, q, margin, work.table)
    if n > len(work.table.key):
        return -float(n)
    fill_contact_rows(model, q, n, n_joint, work)
    solve_rows(model, work, n_joint, n_joint + n)
    for k in range(n):
        gap = work.table.gap[k]
        approach = -row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u)
        if gap > 0.0 and approach > 0.0:
            law = work.table.law[k]
            inverse = mobility(work, n_joint + k)
            if inverse > 0.0:
                energy = 0.5 * approach * approach / inverse
                gap += ONSET * indentation_of(memory.contacts.kinds[law], memory.contacts.parameters[law], energy)
            longest = min(longest, gap / approach)
        elif gap < 0.0 and approach < 0.0:  # where damping is clipped, nothing else tells of the end of the spring
            contacts = memory.contacts
            place = pair_place(model, contacts, work.table, k)
            if place >= 0 or pair_force(contacts, work.table.law[k], place, -gap, approach)[0] == 0.0:
                longest = min(longest, max(LEAVING * gap / approach, LEAST_SHARE * memory.step))
    return longest


@kernel
def record(model: Model, t: float, y: FloatArray, work: Workspace, memory: SmoothMemory, tape: Tape) -> int:
    """Store the state y of time t with its contact forces; returns DONE, or why there is no room."""
    ndof = len(work.free_u)
    q = y[:ndof]
    u = y[ndof : 2 * ndof]
    if tape.n_instants >= len(tape.times):
        return RunStatus.TAPE_FULL
    needed = store_contacts(model, q, tape)
    n = slope(model, t, y, work, memory, memory.slope)
    if n > len(work.table.key):
        memory.detail = n
        return RunStatus.GROW
    if tape.n_points + n > len(tape.spots) and tape.n_points > 0:
        return RunStatus.TAPE_FULL
    if needed > len(tape.table.key) or n > len(tape.spots):
        memory.detail = max(needed, n)
        return RunStatus.GROW_TAPE
    base = 2 * ndof
    tape.counts.lost_friction = y[base + FRICTION]
    tape.counts.lost_impacts = y[base + CONTACT_DAMPING]
    tape.counts.lost_damping = y[base + DAMPING]
    tape.counts.supplied = y[base + WORK]
    for law in range(len(tape.total_impulse)):
        for c in range(2):
            tape.total_impulse[law, c] = y[base + IMPULSES + 2 * law + c]
    stored = 0.0
    tangent = 0
    n_joint = work.n_joint
    for k in range(n):
        law = work.table.law[k]
        depth = max(-work.table.gap[k], 0.0)
        tape.counts.worst_penetration = max(tape.counts.worst_penetration, depth)
        stored += pair_energy(memory.contacts, law, pair_place(model, memory.contacts, work.table, k), depth)
        force_t = 0.0
        state = SLIP
        if tangent < work.n_tangents and work.tangent[tangent] == k:
            r = n_joint + n + tangent
            force_t = work.p[r]
            if abs(row_velocity(work.rows, work.row_body, r, work.dof, u)) < memory.contacts.slip_speed[law]:
                state = STICK
            tangent += 1
        place = contact_point(model, q, work.table, k)
        note_contact(tape, law, place, work.table.normal[k], work.p[n_joint + k], force_t, state)
    kinetic, elastic, potential = energies(model, q, u, work)
    store_state(tape, t, q, u, kinetic, elastic + stored, potential)
    return RunStatus.DONE
