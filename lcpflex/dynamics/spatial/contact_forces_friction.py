"""Friction of compliant contacts in a step of Moreau-Jean, in space: balanced at its end.

With the slip v_f that the step would have at its end without this friction, and h G_TT (2, 2) with the joints, the slip
v at the end solves

    v = v_f - h G_TT phi(|v|) v,   phi(s) = |F_T(s)| / s

In the axes of G_TT, gamma_i its eigenvalues, v_i = a_i / (1 + h gamma_i phi(s)): what is left is one equation for the
speed s = |v|. Of several solutions the one is taken that the slip comes to from where it was, as in the plane.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.contact_forces import add_contact_forces, add_force, mobility
from lcpflex.dynamics.contact_forces_friction import HALVINGS, SETTLED, SWEEPS, fold, free_velocities
from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.joint_response import rate_by_joints, respond
from lcpflex.dynamics.mechanics import solve_rows
from lcpflex.dynamics.spatial.contact_forces import tangential_vector
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.force_laws.friction.kernels import friction_force
from lcpflex.force_laws.friction.spatial_kernels import Pair, friction_pull
from lcpflex.force_laws.history import ContactMemory
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import dot as dot3, row_vector
from lcpflex.solvers.semidefinite import dot

__all__ = ["balanced_pull", "compare_friction", "find_balance", "forces_after"]

Block = tuple[float, float, float]  # entries 11, 12, 22 of h G_TT [s/kg]


@kernel
def left_over(kinds: IntArray, p: FloatArray, mu: float, normal: float, a: Pair, shares: Pair, speed: float) -> Pair:
    """The slip that friction of a slip ``speed`` > 0 leaves of the free one, a, both in the axes of h G_TT."""
    phi = -friction_force(kinds, p, speed, normal, mu, 0.0, 0.0) / speed
    return a[0] / (1.0 + shares[0] * phi), a[1] / (1.0 + shares[1] * phi)


@kernel
def excess(kinds: IntArray, p: FloatArray, mu: float, normal: float, a: Pair, shares: Pair, speed: float) -> float:
    """By how much that is faster than ``speed`` [m/s]."""
    left = left_over(kinds, p, mu, normal, a, shares, speed)
    return math.hypot(left[0], left[1]) - speed


@kernel
def balanced_speed(
    kinds: IntArray, p: FloatArray, mu: float, normal: float, a: Pair, shares: Pair, start: float
) -> float:
    """The first slip speed on the way from ``start`` >= 0 that friction and the free slip a leave as it is."""
    free = math.hypot(a[0], a[1])
    up = 1.0 if start == 0.0 or excess(kinds, p, mu, normal, a, shares, start) >= 0.0 else -1.0
    share = (shares[0] * a[0] * a[0] + shares[1] * a[1] * a[1]) / (free * free)
    peak, valley = fold(kinds, p, mu, share * normal)
    low = start
    high = free if up > 0.0 else 0.0
    for k in range(2):  # bounds of the branches, in the order in which they are met
        bound = peak if (k == 0) == (up > 0.0) else valley
        if math.isfinite(bound) and up * (bound - low) > 0.0 and up * (high - bound) > 0.0:
            if up * excess(kinds, p, mu, normal, a, shares, bound) <= 0.0:
                high = bound
                break
            low = bound
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if up * excess(kinds, p, mu, normal, a, shares, middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def balanced_pull(
    memory: ContactMemory, law: int, mu: float, normal: float, before: Pair, free: Pair, block: Block
) -> Pair:
    """The friction f [N] with f = F_T(free + block f) that the slip ``before`` leads to."""
    kinds = memory.kinds[law]
    p = memory.parameters[law]
    size = math.hypot(free[0], free[1])
    middle, half = 0.5 * (block[0] + block[2]), 0.5 * (block[0] - block[2])
    spread = math.hypot(half, block[1])
    shares = (max(middle + spread, 0.0), max(middle - spread, 0.0))
    if shares[0] == 0.0 or size == 0.0:
        return friction_pull(kinds, p, free, normal, mu, (0.0, 0.0), 0.0)
    angle = 0.5 * math.atan2(block[1], half)
    c, s = math.cos(angle), math.sin(angle)
    a = (c * free[0] + s * free[1], c * free[1] - s * free[0])
    start = max((before[0] * free[0] + before[1] * free[1]) / size, 0.0)
    speed = balanced_speed(kinds, p, mu, normal, a, shares, start)
    if not speed > 0.0:
        return 0.0, 0.0
    left = left_over(kinds, p, mu, normal, a, shares, speed)
    force = friction_force(kinds, p, speed, normal, mu, 0.0, 0.0) / math.hypot(left[0], left[1])
    return force * (c * left[0] - s * left[1]), force * (s * left[0] + c * left[1])


@kernel
def across(contacts: SpatialWork, k: int, force: Vector) -> Pair:
    """Components of a vector along the tangents of entry k."""
    along = row_vector(contacts.rows.table.tangent, k)
    return dot3(force, along), dot3(force, cross(row_vector(contacts.rows.table.normal, k), along))


@kernel
def recall(contacts: SpatialWork, k: int) -> Pair:
    """Friction over normal force that entry k had in the step before: from there the sweeps set out."""
    for i in range(contacts.n_before):
        if contacts.before[i, 0] == contacts.rows.table.key[k]:
            return across(contacts, k, (contacts.before[i, 1], contacts.before[i, 2], contacts.before[i, 3]))
    return 0.0, 0.0


@kernel
def own_block(contacts: SpatialWork, r: int, h: float) -> Block:
    """h G_TT of the rows r and r + 1, with the joints, whose M^-1 rows are known."""
    mixed = 0.0
    for i in range(2):
        if contacts.rows.body[r, i] >= 0:
            mixed += dot(contacts.rows.J[r, i], contacts.rows.solved[r + 1, i], 0, contacts.rows.J.shape[2])
    own, other = mobility(contacts, r), mobility(contacts, r + 1)
    if contacts.rows.n_joint > 0:
        other -= respond(contacts.rows, r + 1)
        own -= respond(contacts.rows, r)
        mixed -= rate_by_joints(contacts.rows, r + 1, contacts.rows.joints.answer)
    return h * max(own, 0.0), h * mixed, h * max(other, 0.0)


@kernel
def push_along(contacts: SpatialWork, r: int, h: float, change: float) -> None:
    """A change of the friction along row r: to the generalised forces, and to the velocities at the end of the step."""
    add_force(contacts, contacts.rows.J, r, change, contacts.friction)
    add_force(contacts, contacts.rows.solved, r, h * change, contacts.free)
    n_joint = contacts.rows.n_joint
    if n_joint == 0:
        return
    respond(contacts.rows, r)
    impulses = contacts.rows.joints.answer
    for i in range(n_joint):
        impulses[i] *= -h * change
    apply_impulses(
        contacts.rows.solved, contacts.rows.body, 0 * n_joint, n_joint, impulses, contacts.rows.dof, contacts.free
    )


@kernel
def velocity_along(contacts: SpatialWork, r: int, u: FloatArray) -> Pair:
    """Slip velocity of the rows r and r + 1."""
    return (
        row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, u),
        row_velocity(contacts.rows.J, contacts.rows.body, r + 1, contacts.rows.dof, u),
    )


@kernel
def balance_contact(u: FloatArray, h: float, j: int, known: bool, contacts: SpatialWork) -> float:
    """Friction of the contact of tangential row j, the others given, or the remembered one; its relative change."""
    k = contacts.rows.tangent[j]
    law, mu, normal = contacts.rows.table.law[k], contacts.rows.mu[k], contacts.p[k, 0]
    if not normal > 0.0:
        return 0.0
    r = contacts.rows.n_joint + contacts.rows.n_contacts + j
    old = (contacts.p[k, 1], contacts.p[k, 2])
    share = recall(contacts, k)
    force = (share[0] * normal, share[1] * normal)
    if not known:
        block = own_block(contacts, r, h)
        slip = velocity_along(contacts, r, contacts.free)
        free = (
            slip[0] - block[0] * old[0] - block[1] * old[1],
            slip[1] - block[1] * old[0] - block[2] * old[1],
        )
        force = balanced_pull(contacts.history, law, mu, normal, velocity_along(contacts, r, u), free, block)
        end = (
            free[0] + block[0] * force[0] + block[1] * force[1],
            free[1] + block[1] * force[0] + block[2] * force[1],
        )
        contacts.sticks[k] = 1 if math.hypot(end[0], end[1]) < contacts.history.slip_speed[law] else 0
    contacts.p[k, 1] = force[0]
    contacts.p[k, 2] = force[1]
    push_along(contacts, r, h, force[0] - old[0])
    push_along(contacts, r + 1, h, force[1] - old[1])
    return math.hypot(force[0] - old[0], force[1] - old[1]) / (mu * normal)


@late_kernel
def balance(model: Any, t: float, q: FloatArray, u: FloatArray, h: float, work: SpatialWork) -> None:
    """Friction of the contacts whose normal forces are known, in sweeps over them: see the plane."""
    contacts = work.compliant
    n = contacts.rows.n_contacts
    first = contacts.rows.n_joint + n
    for i in range(len(u)):
        contacts.friction[i] = 0.0
    if contacts.rows.n_tangents > 0:
        free_velocities(model, t, q, u, h, work)
    solve_rows(model, contacts.rows, first, first + contacts.rows.n_tangents)
    sweeps = SWEEPS if n > 1 else 1
    for sweep in range(-1 if sweeps > 1 else 0, sweeps):  # before the first, what they had in the step before
        worst = 0.0
        for j in range(0, contacts.rows.n_tangents, 2):
            worst = max(worst, balance_contact(u, h, j, sweep < 0, contacts))
        if sweep >= 0 and worst <= SETTLED:
            break
    contacts.n_before = n
    for k in range(n):
        normal = contacts.p[k, 0]
        share = 1.0 / normal if normal > 0.0 else 0.0
        force = tangential_vector(contacts, k, share * contacts.p[k, 1], share * contacts.p[k, 2])
        contacts.before[k, 0] = contacts.rows.table.key[k]
        for c in range(3):
            contacts.before[k, 1 + c] = force[c]


@kernel
def find_balance(model: Any, t: float, q: FloatArray, u: FloatArray, h: float, work: SpatialWork) -> None:
    """:func:`balance`."""
    balance(model, t, q, u, h, work)


@kernel
def forces_after(model: Any, q: FloatArray, u: FloatArray, work: SpatialWork) -> None:
    """Forces of compliant contacts in the state (q, u) that a step led to, with the friction of it: see the plane."""
    keep_friction_of_step(model, q, u, work)


@late_kernel
def keep_friction_of_step(model: Any, q: FloatArray, u: FloatArray, work: SpatialWork) -> None:
    """:func:`forces_after`."""
    contacts = work.compliant
    n, last = contacts.rows.n_contacts, contacts.last
    for k in range(n):
        normal = contacts.p[k, 0]
        share = 1.0 / normal if normal > 0.0 else 0.0
        force = tangential_vector(contacts, k, share * contacts.p[k, 1], share * contacts.p[k, 2])
        last[k, 0] = contacts.rows.table.key[k] if normal > 0.0 else -1.0
        for c in range(3):
            last[k, 1 + c] = force[c]
        last[k, 4] = contacts.sticks[k]
    add_contact_forces(model, q, u, work)
    for k in range(contacts.rows.n_contacts):
        for i in range(n):
            if last[i, 0] == contacts.rows.table.key[k]:
                share_now = across(contacts, k, (last[i, 1], last[i, 2], last[i, 3]))
                contacts.p[k, 1] = share_now[0] * contacts.p[k, 0]
                contacts.p[k, 2] = share_now[1] * contacts.p[k, 0]
                contacts.sticks[k] = 1 if last[i, 4] > 0.0 else 0


@kernel
def compare_friction(u: FloatArray, h: float, work: SpatialWork) -> None:
    """Add up how far the friction of a step is from that of the slip at its end: see the plane."""
    if work.compliant.rows.n_tangents > 0:
        add_missed_friction(u, h, work.compliant)


@late_kernel
def add_missed_friction(u: FloatArray, h: float, contacts: SpatialWork) -> None:
    """``compare_friction`` where there are contacts with friction."""
    history = contacts.history
    for j in range(0, contacts.rows.n_tangents, 2):
        k = contacts.rows.tangent[j]
        law, mu, normal = contacts.rows.table.law[k], contacts.rows.mu[k], contacts.p[k, 0]
        if normal > 0.0:
            slip = velocity_along(contacts, contacts.rows.n_joint + contacts.rows.n_contacts + j, u)
            kinds, p = history.kinds[law], history.parameters[law]
            force = friction_pull(kinds, p, slip, normal, mu, (0.0, 0.0), 0.0)
            contacts.missed[law, 0] += h * math.hypot(force[0] - contacts.p[k, 1], force[1] - contacts.p[k, 2])
            contacts.missed[law, 1] += h * mu * normal
