"""History of compliant contacts, renewed after accepted steps.

A contact that begins notes the speed at which it would have met its indentation from the touch, without loss,

    v_0 = (rate^2 + 2 E(delta) G_NN)^(1/2),

which at the touch itself is the rate of approach, and its effective mass 1/G_NN, with the joints.
"""

from __future__ import annotations

import math

from lcpflex.contact.concave_corners import yield_to_deeper
from lcpflex.contact.detection import ContactTable
from lcpflex.contact.table import weight_of
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.contact_forces import fill_rows, find_contacts, mobility, pair_force, pair_place, pair_stiffness
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.joint_response import factorise_joints, respond
from lcpflex.dynamics.mechanics import factorise, fill_joint_rows, solve_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.elastic.kernels import stored_energy
from lcpflex.force_laws.history import FREE, PLACES, ContactMemory, first_place
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model

__all__ = ["condensed_mobility", "factor_joints", "has_begun", "note_depths", "onset", "roundings", "update_history"]

WITHIN = -1  # law whose indentation is beyond its range: none
ROUNDING = 1e-14  # of the largest coordinate, at least of 1: contacts nearer than that have begun


@kernel
def mark(model: Model, history: ContactMemory, table: ContactTable, n: int) -> None:
    """Mark as seen the places whose node touches their feature, among the first n entries of the table."""
    count = max(len(model.contacts.feature_kind), 1)
    for i in range(len(history.seen)):
        history.seen[i] = 0
    for k in range(n):
        place = first_place(history, table.law[k], table.key[k] // count)
        if place >= 0 and table.gap[k] <= 0.0:
            for i in range(place, place + PLACES):
                if history.feature[i] == table.key[k] % count:
                    history.seen[i] = 1


@kernel
def left_place(history: ContactMemory, place: int) -> int:
    """Of the places of a node, one that it has left and may take along to another feature; -1: none."""
    for i in range(place, place + PLACES):
        if history.feature[i] != FREE and history.seen[i] == 0:
            return i
    return -1


@kernel
def holds(history: ContactMemory, place: int, feature: int) -> int:
    """Of the places of a node, the one for ``feature``; -1: none."""
    for i in range(place, place + PLACES):
        if history.feature[i] == feature:
            return i
    return -1


@kernel
def onset(model: Model, contacts: CompliantContacts) -> bool:
    """Whether a step should have ended before: a contact has begun, turned back from its largest indentation, or
    come back to it; by the gaps and rates of the contacts found.
    """
    history = contacts.history
    table = contacts.rows.table
    count = max(len(model.contacts.feature_kind), 1)
    mark(model, history, table, contacts.rows.n_contacts)
    for k in range(contacts.rows.n_contacts):
        place = first_place(history, table.law[k], table.key[k] // count)
        if place < 0 or table.gap[k] > 0.0:
            continue
        own = holds(history, place, table.key[k] % count)
        if own < 0:
            own = left_place(history, place)
            if own < 0:
                if holds(history, place, FREE) >= 0:
                    return True
                continue  # a third feature at once: it has no history of its own
            history.seen[own] = 1
        if history.turns[table.law[k]] == 1:
            turned = contacts.rate[k] > 0.0 if history.loading[own] == 1 else -table.gap[k] > history.deepest[own]
            if turned:
                return True
    return False


@kernel
def find_rates(model: Model, q: FloatArray, u: FloatArray, slack: float, contacts: CompliantContacts) -> None:
    """Contacts that touch at (q, u), with their rows and rates; gaps count as smaller by ``slack`` [m]."""
    find_contacts(model, q, slack, contacts)
    fill_rows(model, q, contacts)
    for k in range(contacts.rows.n_contacts):
        contacts.rows.table.gap[k] -= slack
        contacts.rate[k] = row_velocity(
            contacts.rows.J, contacts.rows.body, contacts.rows.n_joint + k, contacts.rows.dof, u
        )
    yield_to_deeper(contacts.rows.table, contacts.rows.n_contacts)


@kernel
def has_begun(model: Model, q: FloatArray, u: FloatArray, contacts: CompliantContacts) -> bool:
    """Whether the state (q, u) lies behind the beginning or the turn of a contact that has a history."""
    find_rates(model, q, u, 0.0, contacts)
    return onset(model, contacts)


@kernel
def factor_joints(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Rows of the joints at q, M^-1 times them, and the factor of J M^-1 J^T; M as it was factorised last."""
    contacts = work.compliant
    rows = contacts.rows
    fill_joint_rows(model, t, q, u, work.free.external, rows)
    solve_rows(model, rows, 0, rows.n_joint)
    factorise_joints(rows)


@kernel
def condensed_mobility(contacts: CompliantContacts, r: int) -> float:
    """Diagonal of the Delassus operator for row r with the joints [1/kg], after ``factor_joints``; its M^-1 row is
    known. ``contacts.joints.answer``: what impulses of the joints cancel a unit one of the row.
    """
    value = mobility(contacts, r)
    if contacts.rows.n_joint > 0:
        value -= respond(contacts.rows, r)
    return value


@kernel
def roundings(values: FloatArray) -> float:
    """What may be lost by rounding in a sum of ``values`` and numbers of order 1, amply."""
    largest = 1.0
    for value in values:
        largest = max(largest, abs(value))
    return ROUNDING * largest


@kernel
def note_stiffness(model: Model, contacts: CompliantContacts) -> None:
    """Keep the largest 2 / (step that bears the stiffness and damping of a contact), each by itself."""
    for k in range(contacts.rows.n_contacts):
        depth = -contacts.rows.table.gap[k]
        if not depth > 0.0:
            continue
        law, rate = contacts.rows.table.law[k], abs(contacts.rate[k])
        inverse = weight_of(contacts.rows.table, k) * mobility(contacts, contacts.rows.n_joint + k)
        place = pair_place(model, contacts.history, contacts.rows.table, k)
        stiffness = pair_stiffness(contacts.history, law, place, depth) * inverse
        damping = 0.0
        if rate > 0.0:  # on approach, where no force is clipped
            moving = pair_force(contacts.history, law, place, depth, rate)[0]
            still = pair_force(contacts.history, law, place, depth, 0.0)[0]
            damping = 0.5 * max(moving - still, 0.0) / rate * inverse
        contacts.stiffest = max(contacts.stiffest, damping + math.sqrt(damping * damping + stiffness))


@kernel
def update_history(
    model: Model, t: float, q: FloatArray, u: FloatArray, turned: float, explicit: bool, states: FloatArray,
    work: Workspace,
) -> bool:  # fmt: skip
    """Renew the history in the accepted state (q, u) of time t; whether all contacts are in range of their laws.

    A step ends where a contact begins or turns, up to rounding: what is short of it by no more counts as there, or the
    next step would end at once, and so for ever. For turns, rates count as larger by ``turned`` [m/s]. ``explicit``:
    steps do not follow the forces, and what is too stiff for them is kept. ``states`` (places, 2): of friction, reset
    where a contact begins.
    """
    return len(work.compliant.friction) == 0 or renew_history(model, t, q, u, turned, explicit, states, work)


@late_kernel
def renew_history(
    model: Model, t: float, q: FloatArray, u: FloatArray, turned: float, explicit: bool, states: FloatArray,
    work: Workspace,
) -> bool:  # fmt: skip
    """``update_history`` where compliant contacts may be."""
    contacts = work.compliant
    find_rates(model, q, u, roundings(q), contacts)
    if contacts.needed > 0:
        return False
    n = contacts.rows.n_contacts
    n_joint = contacts.rows.n_joint
    for k in range(n):
        contacts.rate[k] += turned
    begins = onset(model, contacts)
    if begins or explicit:
        factorise(model, q, 0.0, 0.0, work)
        solve_rows(model, contacts.rows, n_joint, n_joint + n)
    if explicit:
        note_stiffness(model, contacts)
    if begins:
        if n_joint > 0:
            factor_joints(model, t, q, u, work)
        for k in range(n):
            contacts.inverse[k] = condensed_mobility(contacts, n_joint + k)
    contacts.out_of_range = update_states(model, q, contacts, states)
    return contacts.out_of_range < 0


@in_space("lcpflex.dynamics.spatial.bristles")
@kernel
def straighten(
    model: Model, q: FloatArray, contacts: CompliantContacts, k: int, states: FloatArray, place: int
) -> None:
    """The states of friction of entry k, which has begun."""
    for j in range(2 if place < len(states) else 0):
        states[place, j] = 0.0


@in_space("lcpflex.dynamics.spatial.bristles")
@kernel
def keep_bristles(
    model: Model, q: FloatArray, contacts: CompliantContacts, k: int, states: FloatArray, place: int
) -> None:
    """The states of friction of entry k, which goes on: in the plane they stay what they are."""


@kernel
def update_states(model: Model, q: FloatArray, contacts: CompliantContacts, states: FloatArray) -> int:
    """Write the history of the contacts found; the law whose indentation is out of its range, or -1."""
    history = contacts.history
    table = contacts.rows.table
    rates = contacts.rate
    count = max(len(model.contacts.feature_kind), 1)
    mark(model, history, table, contacts.rows.n_contacts)
    outside = WITHIN
    for k in range(contacts.rows.n_contacts):
        law = table.law[k]
        depth = max(-table.gap[k], 0.0)
        history.worst[law] = max(history.worst[law], depth)
        if depth > history.stop[law]:
            outside = law
        place = first_place(history, law, table.key[k] // count)
        if place < 0 or table.gap[k] > 0.0:
            continue
        own = holds(history, place, table.key[k] % count)
        if own < 0:
            own = left_place(history, place)
        if own < 0:
            own = holds(history, place, FREE)
            if own < 0:
                continue  # a third feature at once: it has the history of the first
            energy = stored_energy(history.kinds[law], history.parameters[law], depth)  # work done, given back or not
            inverse = contacts.inverse[k]
            history.speed[own] = math.sqrt(rates[k] * rates[k] + 2.0 * energy * inverse)
            history.mass[own] = 1.0 / inverse if inverse > 0.0 else math.inf
            history.deepest[own] = 0.0
            history.loading[own] = 1
            straighten(model, q, contacts, k, states, own)
        else:
            keep_bristles(model, q, contacts, k, states, own)
        history.feature[own] = table.key[k] % count
        history.seen[own] = 1
        if depth >= history.deepest[own]:
            history.deepest[own] = depth
            history.loading[own] = 1
        if rates[k] > 0.0:
            history.loading[own] = 0
    for i in range(len(history.seen)):
        if history.seen[i] == 0:
            history.feature[i] = FREE
    return outside


@kernel
def note_depths(contacts: CompliantContacts) -> None:
    """Keep the largest indentations of the contacts last found: laws that remember nothing have no other account."""
    worst = contacts.history.worst
    for k in range(contacts.rows.n_contacts):
        worst[contacts.rows.table.law[k]] = max(worst[contacts.rows.table.law[k]], -contacts.rows.table.gap[k])
