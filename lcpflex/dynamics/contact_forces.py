"""Forces of compliant contacts as functions of the state and of their history: one computation for all steppers.

    delta = -g_N > 0,   lambda_N = F(delta, deltadot; history),   lambda_T = F_T(gdot_T, lambda_N, mu; friction states)
    h = W_N lambda_N + W_T lambda_T,   stored energy: the integral of the elastic part of F

A stepper finds the contacts at a state, has their rows and forces computed, and adds these where it needs them. The
laws themselves are in :mod:`lcpflex.force_laws`; what contacts remember of their past is renewed between steps only
(:mod:`lcpflex.dynamics.contact_forces_history`), so that within a step forces are smooth functions of the state.
"""

from __future__ import annotations

from lcpflex.contact.concave_corners import yield_to_deeper
from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.table import weight_of
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import fill_contact_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.elastic.kernels import indentation_of
from lcpflex.force_laws.friction.kernels import bristle_rates, friction_force
from lcpflex.force_laws.history import ContactMemory, place_of
from lcpflex.force_laws.normal_kernels import contact_energy, contact_stiffness, normal_force
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.solvers.semidefinite import dot

__all__ = [
    "add_contact_forces",
    "add_force",
    "add_friction",
    "add_impulses",
    "add_normal_forces",
    "compression",
    "contact_forces",
    "elastic_energy",
    "find_contacts",
    "fill_rows",
    "mobility",
    "normal_forces",
    "pair_energy",
    "pair_force",
    "pair_place",
    "pair_stiffness",
    "parting_time",
    "states_of_friction",
    "tangential_force",
]

ONSET = 0.5  # of the time in which a contact would reach its largest indentation: how far a step may go into it
STATES = 2  # of a friction law that has some
LEAVING = 1.001  # times that in which a contact would part at its present rate
LEAST_SHARE = 1e-3  # of the step before, below which that does not shorten one


@kernel
def pair_place(model: Model, history: ContactMemory, table: ContactTable, k: int) -> int:
    """Place of entry k of the table in the history, -1: none."""
    if len(history.feature) == 0:
        return -1
    count = max(len(model.contacts.feature_kind), 1)
    return place_of(history, table.law[k], table.key[k] // count, table.key[k] % count)


@kernel
def pair_force(history: ContactMemory, law: int, place: int, depth: float, rate: float) -> tuple[float, float]:
    """Normal force and its part that stores energy [N], at an indentation > 0 [m] growing with ``rate`` [m/s].

    A contact without a history yet, in a trial state of a step, has the present rate as its impact speed.
    """
    speed = abs(rate)
    mass = 1.0
    deepest = 0.0
    loading = True
    if place >= 0:
        speed = history.speed[place]
        mass = history.mass[place]
        deepest = history.deepest[place]
        loading = history.loading[place] == 1
    return normal_force(history.kinds[law], history.parameters[law], depth, rate, speed, mass, deepest, loading)


@kernel
def pair_energy(history: ContactMemory, law: int, place: int, depth: float) -> float:
    """Energy that a contact can give back [J]."""
    deepest = history.deepest[place] if place >= 0 else 0.0
    loading = place < 0 or history.loading[place] == 1
    return contact_energy(history.kinds[law], history.parameters[law], depth, deepest, loading)


@kernel
def pair_stiffness(history: ContactMemory, law: int, place: int, depth: float) -> float:
    """Slope of the elastic part [N/m]."""
    deepest = history.deepest[place] if place >= 0 else 0.0
    loading = place < 0 or history.loading[place] == 1
    return contact_stiffness(history.kinds[law], history.parameters[law], depth, deepest, loading)


@kernel
def find_contacts(model: Model, q: FloatArray, margin: float, contacts: CompliantContacts) -> None:
    """Compliant contacts with gap <= margin [m] into their table; none, and ``needed``, where it is too small."""
    n = detect(model, q, margin, contacts.rows.table)
    if n > len(contacts.rows.table.key):
        contacts.needed = n
        n = 0
    contacts.rows.n_contacts = n


@in_space("lcpflex.dynamics.spatial.contact_forces")
@kernel
def fill_rows(model: Model, q: FloatArray, contacts: CompliantContacts) -> None:
    """Rows of the contacts found.

    Friction acts on both bodies at one place, halfway between their surfaces. At the surfaces themselves, which
    penetrate, it would be a couple, and angular momentum would be made of nothing.
    """
    n = contacts.rows.n_contacts
    contacts.rows.n_tangents = fill_contact_rows(model, q, n, contacts.rows.n_joint, contacts.rows)
    if len(model.bodies.mass) == 0:
        return
    first = contacts.rows.n_joint + n
    for j in range(contacts.rows.n_tangents):
        for i in range(2):
            if contacts.rows.body[first + j, i] >= 0:
                contacts.rows.J[first + j, i, 2] += 0.5 * contacts.rows.table.gap[contacts.rows.tangent[j]]


@kernel
def normal_forces(model: Model, q: FloatArray, u: FloatArray, contacts: CompliantContacts) -> None:
    """Contacts that touch in the state (q, u), their rows, rates and normal forces."""
    find_contacts(model, q, 0.0, contacts)
    yield_to_deeper(contacts.rows.table, contacts.rows.n_contacts)
    fill_rows(model, q, contacts)
    table = contacts.rows.table
    history = contacts.history
    for k in range(contacts.rows.n_contacts):
        force = 0.0
        elastic = 0.0
        rate = row_velocity(contacts.rows.J, contacts.rows.body, contacts.rows.n_joint + k, contacts.rows.dof, u)
        depth = -table.gap[k]
        if depth > 0.0:
            force, elastic = pair_force(history, table.law[k], pair_place(model, history, table, k), depth, -rate)
        weight = weight_of(table, k)
        contacts.rate[k] = rate
        contacts.p[k, 0] = weight * force
        for c in range(1, contacts.p.shape[1]):
            contacts.p[k, c] = 0.0
        contacts.elastic[k] = weight * elastic
        contacts.sticks[k] = 0


@late_kernel
def friction_forces(
    model: Model, u: FloatArray, states: FloatArray, rates: FloatArray, contacts: CompliantContacts
) -> None:
    """Friction forces at the slip velocities of the state, after ``normal_forces``.

    ``states`` (places, 2): of the friction laws that have some; none: (0, 2). Their time derivatives go to ``rates``.
    """
    history = contacts.history
    first = contacts.rows.n_joint + contacts.rows.n_contacts
    for j in range(contacts.rows.n_tangents):
        k = contacts.rows.tangent[j]
        law = contacts.rows.table.law[k]
        kinds = history.kinds[law]
        p = history.parameters[law]
        mu = contacts.rows.mu[k]
        normal = contacts.p[k, 0]
        slip = row_velocity(contacts.rows.J, contacts.rows.body, first + j, contacts.rows.dof, u)
        bristle = 0.0
        dwell = 0.0
        if len(states) > 0 and normal > 0.0:
            place = pair_place(model, history, contacts.rows.table, k)
            if place >= 0:
                bristle = states[place, 0]
                dwell = states[place, 1]
                change = bristle_rates(kinds, p, slip, normal, mu, bristle, dwell)
                rates[place, 0] = change[0]
                rates[place, 1] = change[1]
        contacts.slip[k] = slip
        contacts.sticks[k] = 1 if abs(slip) < history.slip_speed[law] else 0
        contacts.p[k, 1] = friction_force(kinds, p, slip, normal, mu, bristle, dwell)


@in_space("lcpflex.dynamics.spatial.contact_forces")
@kernel
def find_friction(
    model: Model, q: FloatArray, u: FloatArray, states: FloatArray, rates: FloatArray, contacts: CompliantContacts
) -> None:
    """``friction_forces`` in the state (q, u)."""
    friction_forces(model, u, states, rates, contacts)


@in_space("lcpflex.dynamics.spatial.contact_forces")
@kernel
def tangential_force(contacts: CompliantContacts, j: int) -> float:
    """Friction along tangential row j [N]."""
    return contacts.p[contacts.rows.tangent[j], 1]


@in_space("lcpflex.dynamics.spatial.contact_forces")
@kernel
def states_of_friction(model: Model) -> int:
    """How many states of friction each place has: bristle and dwell."""
    return STATES


@kernel
def contact_forces(
    model: Model, q: FloatArray, u: FloatArray, states: FloatArray, rates: FloatArray, contacts: CompliantContacts
) -> None:
    """All forces of compliant contacts in the state (q, u), with the ``states`` of friction and their ``rates``."""
    normal_forces(model, q, u, contacts)
    find_friction(model, q, u, states, rates, contacts)


@late_kernel
def add_normal_forces(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Add the normal forces to those in ``work``: of springs to conservative, the rest to dissipative."""
    contacts = work.compliant
    normal_forces(model, q, u, contacts)
    for k in range(contacts.rows.n_contacts):
        r = contacts.rows.n_joint + k
        add_force(contacts, contacts.rows.J, r, contacts.elastic[k], work.free.conservative)
        add_force(contacts, contacts.rows.J, r, contacts.p[k, 0] - contacts.elastic[k], work.free.dissipative)


@kernel
def add_friction(work: Workspace) -> None:
    """Add the generalised forces of friction to those in ``work``, to dissipative, and all to total."""
    free = work.free
    for i in range(len(free.total)):
        free.dissipative[i] += work.compliant.friction[i]
        free.total[i] = free.conservative[i] + free.dissipative[i] + free.driving[i]


@kernel
def add_contact_forces(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Add the forces of compliant contacts in the state (q, u) to those in ``work``, by kind."""
    contacts = work.compliant
    if len(contacts.friction) == 0:
        return
    add_normal_forces(model, q, u, work)
    find_friction(model, q, u, contacts.states, contacts.states, contacts)
    for i in range(len(u)):
        contacts.friction[i] = 0.0
    first = contacts.rows.n_joint + contacts.rows.n_contacts
    for j in range(contacts.rows.n_tangents):
        add_force(contacts, contacts.rows.J, first + j, tangential_force(contacts, j), contacts.friction)
    add_friction(work)


@kernel
def elastic_energy(model: Model, contacts: CompliantContacts) -> float:
    """Energy stored in the contacts of ``normal_forces`` [J]."""
    return energy_of_pairs(model, contacts) if contacts.rows.n_contacts > 0 else 0.0


@late_kernel
def energy_of_pairs(model: Model, contacts: CompliantContacts) -> float:
    """``elastic_energy`` where there are contacts."""
    total = 0.0
    table = contacts.rows.table
    for k in range(contacts.rows.n_contacts):
        depth = -table.gap[k]
        if depth > 0.0:
            place = pair_place(model, contacts.history, table, k)
            total += weight_of(table, k) * pair_energy(contacts.history, table.law[k], place, depth)
    return total


@kernel
def add_force(contacts: CompliantContacts, rows: FloatArray, r: int, force: float, out: FloatArray) -> None:
    """out += row r of ``rows`` times a force."""
    dof = contacts.rows.dof
    for i in range(2):
        b = contacts.rows.body[r, i]
        if b >= 0:
            d = dof[b]
            for k in range(dof[b + 1] - d):
                out[d + k] += rows[r, i, k] * force


@in_space("lcpflex.dynamics.spatial.contact_forces")
@kernel
def add_impulses(contacts: CompliantContacts, first: int, out: FloatArray) -> None:
    """Add the forces to the rates of the impulses of declared contacts, normal and tangential, from ``first`` on."""
    for k in range(contacts.rows.n_contacts):
        for c in range(2):
            out[first + 2 * contacts.rows.table.law[k] + c] += contacts.p[k, c]


@kernel
def mobility(contacts: CompliantContacts, r: int) -> float:
    """Diagonal G_rr of the Delassus operator [1/kg], whose M^-1 row is known; without joints: not less than with."""
    total = 0.0
    for i in range(2):
        if contacts.rows.body[r, i] >= 0:
            total += dot(contacts.rows.J[r, i], contacts.rows.solved[r, i], 0, contacts.rows.J.shape[2])
    return total


@kernel
def compression(contacts: CompliantContacts, k: int, speed_squared: float, inverse: float) -> float:
    """Share ONSET of the indentation [m] in which contact k, of effective mass 1/``inverse``, would stop."""
    if not inverse > 0.0:
        return 0.0
    law = contacts.rows.table.law[k]
    history = contacts.history
    return ONSET * indentation_of(history.kinds[law], history.parameters[law], 0.5 * speed_squared / inverse)


@kernel
def parting_time(gap: float, approach: float, last: float) -> float:
    """Step [s] that goes not far beyond the end of an indentation, if that is not much less than the ``last`` step."""
    return max(LEAVING * gap / approach, LEAST_SHARE * last)
