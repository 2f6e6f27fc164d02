"""Rates of the state of an event-driven run while its index sets are fixed: what Runge-Kutta steps integrate."""

from __future__ import annotations

from lcpflex.dynamics.acceleration import ContactSets, assemble, fixed_forces
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.contact_forces import add_impulses
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import rate
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import EventMemory

__all__ = ["slope"]


@kernel
def add_compliant(contacts: CompliantContacts, u: FloatArray, base: int, out: FloatArray) -> None:
    """Losses and impulses of compliant contacts; what their damping takes is also among that of all damping."""
    for k in range(contacts.rows.n_contacts):
        out[len(out) - 1] -= (contacts.p[k, 0] - contacts.elastic[k]) * contacts.rate[k]
    for i in range(len(contacts.friction)):
        power = contacts.friction[i] * u[i]
        out[base] -= power
        out[base + 1] += power
    add_impulses(contacts, base + 3, out)


@in_space("lcpflex.dynamics.spatial.acceleration")
@kernel
def find_slips(work: Workspace, sets: ContactSets, u: FloatArray) -> None:
    """Directions of slip of the contacts that slide: in the plane the sets tell them."""


@kernel
def slope(model: Model, t: float, y: FloatArray, work: Workspace, memory: EventMemory, out: FloatArray) -> None:
    """out = dy/dt with the sets as they are; constraint forces are left in ``work.impulses.p``."""
    nq, ndof = memory.nq, len(memory.u)
    base = nq + ndof
    q = y[:nq]
    u = y[nq:base]
    n = memory.n_contacts
    assemble(model, t, q, u, n, work, memory.sets)
    find_slips(work, memory.sets, u)
    fixed_forces(work, memory.sets)
    for i in range(base, len(out)):
        out[i] = 0.0
    rate(model, q, u, out)
    for i in range(ndof):
        out[nq + i] = work.free.u[i]
        out[base + 1] -= work.free.dissipative[i] * u[i]
        out[base + 2] += work.free.driving[i] * u[i]
    n_joint = work.rows.n_joint
    for r in range(n_joint):
        if work.rows.rate[r] != 0.0:
            out[base + 2] += work.impulses.p[r] * row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)
    add_compliant(work.compliant, u, base, out)
    add_rates(work, memory, u, base, out)


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def add_rates(work: Workspace, memory: EventMemory, u: FloatArray, base: int, out: FloatArray) -> None:
    """Rates of what contact forces do and sum up to, after ``fixed_forces``."""
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    for k in range(n):
        law = base + 3 + 2 * work.rows.table.law[k]
        out[law] += work.impulses.p[n_joint + k]
        tangent = memory.sets.tangent_of[k]
        if tangent >= 0:
            r = n_joint + n + tangent
            out[law + 1] += work.impulses.p[r]
            out[base] -= work.impulses.p[r] * row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)
